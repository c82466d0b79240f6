#include <pybind11/pybind11.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <string>

#include "bindings.h"

namespace planar::python {
namespace {

namespace py = pybind11;

int level_of(spdlog::level::level_enum level) {
  constexpr int kDebug = 10, kInfo = 20, kWarning = 30, kError = 40;
  if (level >= spdlog::level::err) return kError;
  if (level >= spdlog::level::warn) return kWarning;
  return level >= spdlog::level::info ? kInfo : kDebug;
}

/// Hands the library's messages to logging.getLogger("planar_servo"). The interpreter's lock is the
/// only one that it takes: a second one could be held by a thread that waits for this one.
class LoggingSink : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const py::gil_scoped_acquire lock;
    try {
      const py::object logger = py::module_::import("logging").attr("getLogger")("planar_servo");
      const py::str text(message.payload.data(), message.payload.size());
      logger.attr("log")(level_of(message.level), "%s", text);
    } catch (py::error_already_set& error) {
      if (error.matches(PyExc_KeyboardInterrupt))
        PyErr_SetInterrupt();  // Ctrl-C came here by chance and is meant for the work
      else
        error.discard_as_unraisable("planar_servo's log");
    }
  }
  void flush_() override {}
};

void log_to(std::shared_ptr<spdlog::sinks::sink> sink) {
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("planar_servo", std::move(sink)));
  spdlog::set_level(spdlog::level::info);
}

/// Throws away what threads still say while the interpreter ends.
class NoSink : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
  void sink_it_(const spdlog::details::log_msg&) override {}
  void flush_() override {}
};

}  // namespace

void bind_logging(py::module_&) {
  log_to(std::make_shared<LoggingSink>());
  py::module_::import("atexit").attr("register")(
      py::cpp_function([] { log_to(std::make_shared<NoSink>()); }));
}

}  // namespace planar::python
