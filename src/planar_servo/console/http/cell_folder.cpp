#include "planar_servo/console/http/cell_folder.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/console/doctor/next_step.h"
#include "planar_servo/console/json_values.h"
#include "planar_servo/files/provenance.h"

namespace planar {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kDeepest = 3;  // folders below the cell's in which reports are sought
constexpr std::size_t kMostReports = 200;
constexpr std::uintmax_t kMostBytes = 64u << 20;

const char* served_type(const fs::path& name) {
  const std::string ending = name.extension().string();
  if (ending == ".html") return "text/html; charset=utf-8";
  if (ending == ".png") return "image/png";
  if (ending == ".svg") return "image/svg+xml";
  return nullptr;
}

std::string time_text(fs::file_time_type time) {
  const auto since = time - fs::file_time_type::clock::now();
  const auto then = std::chrono::system_clock::now() +
                    std::chrono::duration_cast<std::chrono::system_clock::duration>(since);
  return utc_text(std::chrono::system_clock::to_time_t(then));
}

ordered_json file_json(const MadeFile& file, const std::map<fs::path, Refusal>& faults) {
  const std::string maker = fs::exists(file.path) ? read_maker(file.path) : "";
  const std::size_t comma = maker.find(", ");
  const bool named = comma != std::string::npos;
  const auto fault = faults.find(file.path);
  return {{"role", name_in(kRoles, file.role)},
          {"path", file.path.filename().string()},
          {"exists", fs::exists(file.path)},
          {"made", named ? ordered_json(maker.substr(comma + 2)) : ordered_json(nullptr)},
          {"program", named ? ordered_json(maker.substr(0, comma)) : ordered_json(nullptr)},
          {"fault", fault == faults.end() ? ordered_json(nullptr) : refusal_json(fault->second)}};
}

ordered_json next_json(const std::string& text, const WorkStep& step = {}) {
  return {{"text", text}, {"command", step.command}, {"is_calculated", step.is_calculated}};
}

}  // namespace

std::optional<ServedFile> served_file(const fs::path& folder, const std::string& name) {
  const fs::path relative(name);
  const char* type = served_type(relative);
  if (type == nullptr || relative.is_absolute() || name.find('\0') != std::string::npos)
    return std::nullopt;
  std::error_code error;
  const fs::path path = (folder / relative).lexically_normal();
  const fs::path real = fs::canonical(path, error);
  if (error || real != path || real.lexically_relative(folder).string().rfind("..", 0) == 0)
    return std::nullopt;
  if (!fs::is_regular_file(real, error) || fs::file_size(real, error) > kMostBytes || error)
    return std::nullopt;
  return ServedFile{real, type};
}

ordered_json reports_json(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, std::string>> reports;
  std::error_code error;
  fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    if (it.depth() >= kDeepest) it.disable_recursion_pending();
    if (it->path().extension() != ".html" || !it->is_regular_file(error) || it->is_symlink(error))
      continue;
    reports.emplace_back(it->last_write_time(error),
                         it->path().lexically_relative(folder).generic_string());
  }
  std::sort(reports.rbegin(), reports.rend());
  if (reports.size() > kMostReports) reports.resize(kMostReports);
  auto list = ordered_json::array();
  for (const auto& [time, name] : reports)
    list.push_back({{"name", name}, {"path", "/reports/" + name}, {"made", time_text(time)}});
  return list;
}

ordered_json files_json(const CellSettings& cell, const std::string& board) {
  const bool with_map = fs::exists(cell.error_map);
  std::map<fs::path, Refusal> faults;
  auto list = ordered_json::array();
  ordered_json next;
  try {
    for (const StaleFile& stale : stale_files(cell, with_map)) faults.emplace(stale.path, stale);
    const auto step = next_step(cell.file, board);
    next = step ? next_json(step->name + ": " + step->what, *step)
                : next_json("nothing is left to do");
  } catch (const InputError& e) {
    next = next_json(e.what());
  }
  for (const MadeFile& file : made_files(cell, true)) list.push_back(file_json(file, faults));
  return {{"files", list}, {"next", next}};
}

}  // namespace planar
