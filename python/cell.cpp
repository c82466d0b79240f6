#include <fmt/format.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <variant>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/ready_cell.h"
#include "planar_servo/work/run/servo_report.h"
#include "planar_servo/work/run/servo_run.h"

namespace planar::python {
namespace {

namespace fs = std::filesystem;

// While Python ends, cells at work are stopped and no other work begins.
std::atomic<bool> is_ending{false};
std::atomic<int> at_work{0};

/// Brings arms to rest that other threads still move when Python ends.
void rest_at_end() {
  constexpr auto kLongest = std::chrono::seconds(10);
  is_ending = true;
  const py::gil_scoped_release release;
  const auto end = std::chrono::steady_clock::now() + kLongest;
  while (at_work > 0 && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

/// Stops the arm once Python has a signal, such as Ctrl-C, or somebody asks for it. A signal's
/// exception is kept until the motion has ended. Only Python's main thread sees signals.
class Stop {
 public:
  bool asked() {
    if (is_ending || is_asked_ || interruption_) return true;
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() == 0) return false;
    interruption_.emplace();
    return true;
  }
  void ask() { is_asked_ = true; }
  /// Calls `work` while Python runs on. Throws the signal's exception in place of what became of a
  /// work that it stopped.
  template <typename Work>
  auto during(const Work& work) -> decltype(work()) {
    is_asked_ = false;
    interruption_.reset();
    try {
      const py::gil_scoped_release release;
      return work();
    } catch (...) {
      if (!interruption_) throw;
    }
    throw py::error_already_set(*interruption_);
  }

 private:
  std::atomic<bool> is_asked_{false};
  std::optional<py::error_already_set> interruption_;
};

/// Checks the direction of a tool, up to one turn either way.
double direction(double phi) {
  if (!(std::abs(phi) <= 2.0 * kPi))
    throw InputError({fmt::format("is {:g}", phi),
                      "radians from -2 pi to 2 pi are needed; numpy.radians() makes them", "phi"});
  return phi;
}

using OnStep = std::optional<std::function<void(const ServoStep&)>>;

/// Calls back into Python with each step.
PositionServo::Observer observer_of(const OnStep& on_step) {
  if (!on_step) return {};
  return [&call = *on_step](const ServoStep& step) {
    const py::gil_scoped_acquire lock;
    call(step);
  };
}

/// A cell that is opened for motion. One thread at a time may work with it.
class Cell {
 public:
  Cell(const fs::path& path, bool use_error_map, bool accept_stale, bool accept_map,
       bool check_health, const MayHome& may_home) {
    const py::gil_scoped_release release;
    const CellSettings cell = read_cell(path);
    require_devices(cell);
    request_.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(cell, use_error_map));
    require_calibrated(*request_.cell);  // before a device is opened
    request_.policy.center = cell.lamps.method;
    request_.accepted.stale = accept_stale;
    request_.accepted.map = accept_map;
    request_.policy.checks_health = check_health;
    request_.may_home = may_home;
    request_.stop = [this] { return stop_.asked(); };
    devices_ = open_cell(cell);
  }
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;
  ~Cell() { shut(); }

  ServoResult move_to(const py::object& p, const std::optional<double>& phi,
                      const OnStep& on_step) {
    const Eigen::VectorXd place = vector_of("p", p, 2);
    require_metres("p", place);
    const double turn = phi ? direction(*phi) : request_.cell->settings.tool_orientation;
    return work([&] {
      ReadyCell& cell = ready();
      if (const auto unwell = cell.examine_if_due(); unwell && !unwell->empty())
        throw WorkError(*unwell, Cause::kContradiction);
      const ServoResult result = attempts(cell, {place, turn}, observer_of(on_step));
      cell.keep_lessons_if_due();
      return result;
    });
  }

  /// Moves to the targets of a table as planar-servo does, with its files.
  py::dict run(const fs::path& targets, const fs::path& out, bool resume, const OnStep& on_step,
               const std::optional<fs::path>& on_work, const std::string& tool) {
    const ServoFigures figures = work([&] {
      ready_.reset();  // the run makes its own
      ServoRequest request = request_;
      request.folder.path = out;
      request.folder.resume = resume;
      request.policy.learns = request.cell->settings.servo.learns;
      const CellSettings& cell = request.cell->settings;
      std::vector<TargetRow> rows = read_targets(targets);
      if (on_work) {
        request.works = read_works(*on_work, *request.cell, request.accepted.stale);
        rows = on_works(rows, request.works->works);
      }
      rows = CellTools(cell, tool, request.accepted.stale).with_tips(rows);
      const auto show = observer_of(on_step);
      ServoRun run(request, *devices_, [&](const ServoSight& sight) {
        if (show) show(sight.step);
      });
      run_servo(run, rows);
      run.finish();
      ServoFigures found = figures_of(run.results());
      write_run(request, run, found, targets);
      return found;
    });
    py::dict told;
    told["targets"] = figures.targets;
    told["reached"] = figures.reached;
    told["iterations_median"] = figures.iterations_median;
    told["seconds_per_target"] = figures.seconds_per_target;
    return told;
  }

  py::array_t<std::uint8_t> picture() {
    const Frame frame = work([&] {
      devices_->camera().set_region(cv::Rect({}, devices_->camera().sensor_size_px()));
      FrameResult result = devices_->camera().next_frame();
      if (result.status != FrameStatus::kOk)
        throw WorkError(std::string("the camera gave no picture: ") + name(result.status),
                        Cause::kDevice);
      ready_.reset();  // its sensor knows another region
      return result.frame;
    });
    const cv::Mat& image = frame.image;
    auto* const held = new cv::Mat(image);
    const py::capsule owner(held, [](void* mat) { delete static_cast<cv::Mat*>(mat); });
    return {{image.rows, image.cols},
            {static_cast<py::ssize_t>(image.step[0]), py::ssize_t{1}},
            held->data,
            owner};
  }

  py::object joints() {
    return array_from(work([&] { return Eigen::Vector3d(ready().robot().commanded_joints()); }));
  }

  py::object true_position() {
    const auto p = work([&]() -> std::optional<Eigen::Vector2d> {
      const auto truth = devices_->truth();
      return truth ? truth->judge("", {}).p : std::nullopt;
    });
    return p ? py::object(array_from(*p)) : py::none();
  }

  void stop() { stop_.ask(); }
  void close() {
    work([&] { shut(); });
  }
  bool is_open() const { return is_open_; }
  std::string file() const { return request_.cell->settings.file.string(); }

 private:
  /// Works with the devices; refuses a closed cell, and a second thread or a callback.
  template <typename Work>
  auto work(const Work& work) -> decltype(work()) {
    if (is_busy_.exchange(true))
      throw WorkError({"the cell is at work in another call",
                       "wait for its end, or stop() it; on_step must not move the cell", "",
                       Cause::kBusy});
    struct Idle {
      std::atomic<bool>& is_busy;
      ~Idle() {
        is_busy = false;
        --at_work;
      }
    } const idle{is_busy_};
    ++at_work;
    if (is_ending) throw WorkError("Python is ending", Cause::kStopped);
    if (!devices_) throw InputError(Refusal{"the cell is closed", "open it again by Cell(path)"});
    return stop_.during(work);
  }

  /// Moves to the target, again after lost drives or a lost camera are back.
  static ServoResult attempts(ReadyCell& cell, const TipPose& target,
                              const PositionServo::Observer& observer) {
    int recoveries_left = ReadyCell::kMaxDriveRecoveries;
    int failures_left = ReadyCell::kMaxCameraFailures;
    while (true) {
      ServoResult result = cell.with_drives("move_to", recoveries_left,
                                            [&] { return cell.servo().move_to(target, observer); });
      if (result.status != ServoStatus::kLostCamera || failures_left-- == 0) return result;
      const double deadline_s = cell.clock().now_s() + kCameraPatience_s;
      if (!cell.wait_for_camera("move_to", result.reason, deadline_s)) return result;
    }
  }

  ReadyCell& ready() {
    if (!ready_) {
      ready_ = std::make_unique<ReadyCell>(request_, *devices_);
      ready_->switch_on();
    }
    return *ready_;
  }

  /// Halts and closes what is open. Threads of the devices may want to log meanwhile.
  void shut() {
    const auto close = [&] {
      ready_.reset();
      devices_.reset();
      is_open_ = false;
    };
    if (!PyGILState_Check()) return close();
    const py::gil_scoped_release release;
    close();
  }

  ServoRequest request_;
  Stop stop_;
  std::atomic<bool> is_busy_{false}, is_open_{true};
  std::unique_ptr<CellDevices> devices_;
  std::unique_ptr<ReadyCell> ready_;
};

std::unique_ptr<Cell> open(const fs::path& path, bool use_error_map, bool accept_stale,
                           bool accept_map, bool check_health, bool home, bool at_marks,
                           bool nearest_turn) {
  // What is said of where the arm stands holds once: a drive that loses its position later stands
  // anywhere.
  const auto turn = std::make_shared<bool>(nearest_turn), marks = std::make_shared<bool>(at_marks);
  const MayHome may_home = [=](Homing way, const std::string&) {
    if (way == Homing::kSearch) return home;
    return std::exchange(way == Homing::kTurn ? *turn : *marks, false);
  };
  return std::make_unique<Cell>(path, use_error_map, accept_stale, accept_map, check_health,
                                may_home);
}

}  // namespace

void bind_cell(py::module_& m) {
  py::module_::import("atexit").attr("register")(py::cpp_function(&rest_at_end));
  py::class_<Cell>(
      m, "Cell",
      "A calibrated cell, virtual or real, opened for motion. Ctrl-C brings the arm to\n"
      "rest and raises KeyboardInterrupt. One thread at a time may work with it.")
      .def(py::init(&open), py::arg("path"), py::kw_only(), py::arg("use_error_map") = true,
           py::arg("accept_stale") = false, py::arg("accept_map") = false,
           py::arg("check_health") = true, py::arg("home") = false, py::arg("at_marks") = false,
           py::arg("nearest_turn") = false,
           "Reads the cell file and all that it names, and opens the devices; nothing moves. The\n"
           "options are those of planar-servo. home lets drives search their home switch, or be\n"
           "found by sight, at_marks says that motors without one stand at their marks,\n"
           "nearest_turn that motors found by sight are on the turn nearest to home.")
      .def(
          "move_to", &Cell::move_to, py::arg("p"), py::arg("phi") = py::none(), py::kw_only(),
          py::arg("on_step") = py::none(),
          "Moves the end point to p (2,), metres, base frame, with the tool along phi (radians; "
          "by\n"
          "default that of the cell). on_step(step) is called while the arm rests. A target that\n"
          "is not reached has its status; WorkError means that a device failed or the cell is not\n"
          "well.")
      .def("run", &Cell::run, py::arg("targets"), py::arg("out"), py::kw_only(),
           py::arg("resume") = false, py::arg("on_step") = py::none(), py::arg("work") = py::none(),
           py::arg("tool") = "",
           "Moves to the targets of a table and writes steps.csv, results.csv, run.yaml and\n"
           "report.html to out, as planar-servo does. With work, the file of planar-find-work,\n"
           "targets are those of its drawing; tool is the cell's tool that goes to targets which\n"
           "name none. Returns its figures.")
      .def("picture", &Cell::picture, "Returns the whole sensor's next picture, uint8.")
      .def_property_readonly("joints", &Cell::joints,
                             "(3,): the commanded joints, radians. Switches the drives on.")
      .def("true_position", &Cell::true_position,
           "Returns the true end point (2,) of a virtual cell, None of a real one; to judge only.")
      .def("stop", &Cell::stop, "Brings the arm to rest; call it from another thread.")
      .def("close", &Cell::close, "Closes the devices.")
      .def("__repr__",
           [](const Cell& cell) {
             return fmt::format("<Cell {}, {}>", cell.file(), cell.is_open() ? "open" : "closed");
           })
      .def_property_readonly("is_open", &Cell::is_open)
      .def_property_readonly("path", &Cell::file)
      .def(
          "__enter__", [](Cell& cell) -> Cell& { return cell; }, py::return_value_policy::reference)
      .def(
          "__exit__",
          [](Cell& cell, const py::object&, const py::object&, const py::object&) {
            if (cell.is_open()) cell.close();
          },
          py::arg("kind"), py::arg("error"), py::arg("trace"));
}

}  // namespace planar::python
