#include "report_option.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr char kNone[] = "none";

}  // namespace

void add_report_option(CLI::App& app, std::string& report) {
  app.add_option("--report", report,
                 "write a page that shows what was found and whether it is good; by default beside "
                 "the output, with .html for its ending, when standard output is a terminal; none "
                 "for no page")
      ->type_name("FILE.html|none");
}

std::optional<fs::path> page_for(const std::string& report, const fs::path& output) {
  if (report == kNone) return std::nullopt;
  fs::path page = report;
  if (report.empty()) {
    if (isatty(STDOUT_FILENO) == 0 || (fs::exists(output) && !fs::is_regular_file(output)))
      return std::nullopt;
    page = fs::path(output).replace_extension(".html");
  }
  if (page.extension() != ".html")
    throw InputError("--report is '" + report + "'; a name that ends in .html, or none, is needed");
  if (page.lexically_normal() == output.lexically_normal())
    throw InputError(output.string() +
                     ": is the name of the page as well; name another file for --report, or none");
  require_writable(page, "page");
  return page;
}

void write_page(const fs::path& page, const std::string& text) {
  write_file(page, text);
  spdlog::info(fmt::format("{} shows it", page.string()));
}

}  // namespace planar
