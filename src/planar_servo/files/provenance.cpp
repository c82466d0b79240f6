#include "planar_servo/files/provenance.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/base/io/csv_fields.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr char kRoleRemark[] = "# role: ", kRemark[] = "# made from: ";
constexpr char kRowsRemark[] = "# rows: ";
constexpr char kProgram[] = "program: ", kCreated[] = "created: ", kEdited[] = "edited_by_hand: ";
constexpr int kHeaderLines = 32;  // within which the list of inputs begins; comments go on
constexpr std::size_t kShownDigits = 8;

void add_origin(std::vector<Origin>& origins, const std::string& role, std::string name,
                std::string sha256) {
  const std::optional<Role> known = value_named(kRoles, role);
  if (known) origins.push_back({*known, std::move(name), std::move(sha256)});
}

/// Reads a line `# made from: NAME SHA256` that follows the line of its role. Returns whether it
/// can be read.
bool add_remark(std::vector<Origin>& origins, const std::string& role, const std::string& line) {
  constexpr std::size_t kHexDigits = 64;
  const std::string text = line.substr(std::size(kRemark) - 1);
  const std::size_t space = text.rfind(' ');
  if (space == std::string::npos || role.empty() || text.size() - space - 1 != kHexDigits ||
      text.find_first_not_of("0123456789abcdef", space + 1) != std::string::npos)
    return false;
  add_origin(origins, role, text.substr(0, space), text.substr(space + 1));
  return true;
}

std::vector<Origin> origins_of_list(const std::string& yaml) {
  std::vector<Origin> origins;
  try {
    for (const YAML::Node& item : YAML::Load(yaml)["inputs"])
      if (item.IsMap() && item["role"] && item["name"] && item["sha256"])
        add_origin(origins, item["role"].Scalar(), item["name"].Scalar(), item["sha256"].Scalar());
  } catch (const YAML::Exception&) {
    return {};  // its own reader says what is wrong with the file
  }
  return origins;
}

/// Returns the lines of a table that are not comments.
std::string rows_of(const std::string& table) {
  std::string rows;
  for (std::size_t begin = 0; begin < table.size();) {
    const std::size_t end = std::min(table.find('\n', begin), table.size() - 1) + 1;
    if (table[begin] != '#') rows.append(table, begin, end - begin);
    begin = end;
  }
  return rows;
}

/// Returns the programs that make a file of this role anew when an origin has changed.
std::string remedy(Role made, Role origin) {
  if (made == Role::kErrorMap && origin != Role::kPairs)
    return fmt::format("{}, then {},", program_for(Role::kPairs), program_for(made));
  return program_for(made);
}

std::string digits(const Origin& origin) {
  return origin.sha256.substr(0, kShownDigits) + "...";
}

Refusal contradiction(const MadeFile& file, const Origin& origin, const std::string& other,
                      const Origin& differs) {
  return {fmt::format("was made with {} {}, {} is {}", origin.name, digits(origin), other,
                      digits(differs)),
          fmt::format("run {} again", remedy(file.role, origin.role)), file.path, Cause::kForeign};
}

Origin block(Role role, const CellSettings& cell, const char* key, const std::string& content) {
  return {role, fmt::format("{} ({})", key, cell.file.filename().string()), sha256(content)};
}

}  // namespace

const Origin* find_role(const std::vector<Origin>& origins, Role role) {
  const auto found = std::find_if(origins.begin(), origins.end(),
                                  [&](const Origin& origin) { return origin.role == role; });
  return found == origins.end() ? nullptr : &*found;
}

const char* program_for(Role role) {
  switch (role) {
    case Role::kCamera:
      return "planar-calibrate-camera";
    case Role::kLamps:
      return "planar-locate-lamps";
    case Role::kToolTip:
      return "planar-teach-tool";
    case Role::kWork:
      return "planar-find-work";
    case Role::kErrorMap:
      return "planar-fit-error-map";
    case Role::kArmFound:
      return "planar-fit-error-map --arm-out";
    default:
      return "planar-pair-tracker";
  }
}

std::vector<MadeFile> calibration_files(const CellSettings& cell, bool with_error_map) {
  std::vector<MadeFile> files{{Role::kCamera, cell.camera_model},
                              {Role::kWorkplane, cell.workplane},
                              {Role::kTool, cell.tool}};
  if (with_error_map) files.push_back({Role::kErrorMap, cell.error_map});
  return files;
}

std::vector<MadeFile> made_files(const CellSettings& cell, bool with_error_map) {
  std::vector<MadeFile> files = calibration_files(cell, with_error_map);
  if (cell.health) files.push_back({Role::kHealth, *cell.health});
  if (cell.arm_found) files.push_back({Role::kArmFound, *cell.arm_found});
  return files;
}

Origin origin_of(const MadeFile& file) {
  return {file.role, file.path.filename().string(), content_sha256(file.path)};
}

Origin origin_of(const MadeFile& file, const std::string& text) {
  return {file.role, file.path.filename().string(), content_sha256_of(text)};
}

std::vector<Origin> origins_in(const CellSettings& cell) {
  const LampLayout& lamps = cell.lamps.layout;
  std::string datum;
  for (const Monument& monument : cell.datum)
    datum += fmt::format("{}: {} {} {}\n", monument.id, monument.p_B.x(), monument.p_B.y(),
                         monument.p_B.z());
  return {block(Role::kLampLayout, cell, "lamps",
                fmt::format("{} {} {}", lamps.separation_m, lamps.diameters_m[0],
                            lamps.diameters_m[1])),
          block(Role::kImageSize, cell, "image size",
                fmt::format("{} {}", cell.camera.width_px, cell.camera.height_px)),
          block(Role::kDatum, cell, "datum", datum)};
}

Origin arm_origin(const CellSettings& cell) {
  const ArmGeometry& arm = cell.arm.geometry;
  const std::array<Coupling, 2>& coupling = cell.transmission.coupling;
  return block(
      Role::kArm, cell, "arm",
      fmt::format("{} {} {} {} {} {}", arm.link_lengths_m[0], arm.link_lengths_m[1],
                  static_cast<int>(arm.positive_rotation), static_cast<int>(cell.arm.elbow),
                  static_cast<int>(coupling[0]), static_cast<int>(coupling[1])));
}

std::vector<Origin> origins_in(const CellSettings& cell, const std::vector<MadeFile>& files) {
  std::vector<Origin> origins = origins_in(cell);
  for (const MadeFile& file : files)
    if (fs::exists(file.path)) origins.push_back(origin_of(file));
  return origins;
}

std::vector<Origin> read_origins(const fs::path& path) {
  std::ifstream in = open_file(path);
  std::vector<Origin> remarks;
  std::string line, list, role;
  for (int i = 0; (i < kHeaderLines || line[0] == '#') && std::getline(in, line); ++i) {
    const std::string remark(remark_of(line));
    if (remark.rfind(kRoleRemark, 0) == 0) role = remark.substr(std::size(kRoleRemark) - 1);
    if (remark.rfind(kRemark, 0) == 0 && !add_remark(remarks, role, remark))
      throw InputError({fmt::format("does not say readably what it was made from: '{}'", remark),
                        "take the file as its program wrote it, or make it again",
                        fmt::format("{}:{}", path.string(), i + 1)});
    if (line != "inputs:") continue;
    list = line + "\n";
    while (std::getline(in, line) && (!line.empty() && (line[0] == ' ' || line[0] == '-')))
      list += line + "\n";
    return origins_of_list(list);
  }
  return remarks;
}

std::string read_maker(const fs::path& path) {
  std::ifstream in = open_file(path);
  std::string line, program, created, edited;
  for (int i = 0; i < kHeaderLines && std::getline(in, line); ++i) {
    line.erase(std::remove(line.begin(), line.end(), '"'), line.end());
    if (line.rfind(kProgram, 0) == 0) program = line.substr(std::size(kProgram) - 1);
    if (line.rfind(kCreated, 0) == 0) created = line.substr(std::size(kCreated) - 1);
    if (line.rfind(kEdited, 0) == 0)
      edited = ", edited by hand " + line.substr(std::size(kEdited) - 1);
  }
  return program.empty() ? "" : fmt::format("{}, {}{}", program, created, edited);
}

std::vector<Origin> with_origins_of(std::vector<Origin> made_from, const fs::path& file) {
  for (Origin& origin : read_origins(file))
    if (find_role(made_from, origin.role) == nullptr) made_from.push_back(std::move(origin));
  return made_from;
}

std::vector<InputRecord> input_records(const std::vector<Origin>& origins) {
  std::vector<InputRecord> records;
  records.reserve(origins.size());
  for (const Origin& origin : origins)
    records.push_back({origin.name, origin.sha256, name_in(kRoles, origin.role)});
  return records;
}

std::vector<std::string> csv_remarks(const std::vector<Origin>& origins) {
  std::vector<std::string> remarks;
  remarks.reserve(2 * origins.size());
  for (const Origin& origin : origins) {
    remarks.push_back(kRoleRemark + std::string(name_in(kRoles, origin.role)));
    remarks.push_back(fmt::format("{}{} {}", kRemark, origin.name, origin.sha256));
  }
  return remarks;
}

std::string remark_in(const fs::path& table, const std::string& key) {
  std::ifstream in = open_file(table);
  std::string line;
  for (int i = 0; (i < kHeaderLines || line[0] == '#') && std::getline(in, line); ++i)
    if (line.rfind(key, 0) == 0) return line.substr(key.size());
  return "";
}

std::string with_row_hash(const std::string& table) {
  const std::size_t second_line = table.find('\n') + 1;
  return table.substr(0, second_line) + kRowsRemark + sha256(rows_of(table)) + "\n" +
         table.substr(second_line);
}

bool has_changed_rows(const fs::path& table) {
  const std::string written = remark_in(table, kRowsRemark);
  return !written.empty() && written != sha256(rows_of(read_file(table)));
}

std::vector<StaleFile> missing_files(const std::vector<MadeFile>& files) {
  std::vector<StaleFile> missing;
  for (const auto& [role, path] : files)
    if (!fs::exists(path))
      missing.push_back({{"does not exist yet", std::string("make it with ") + program_for(role),
                          path, Cause::kMissing},
                         path});
  return missing;
}

std::vector<StaleFile> contradictions(const std::vector<MadeFile>& files,
                                      const std::vector<Origin>& present,
                                      const std::vector<Role>& compared) {
  std::vector<StaleFile> found;
  std::map<Role, std::pair<Origin, std::string>> known;
  for (const Origin& origin : present) known.try_emplace(origin.role, origin, "this one");
  for (const MadeFile& file : files) {
    const std::string its = "that of " + file.path.filename().string();
    for (const Origin& origin : read_origins(file.path)) {
      if (std::count(compared.begin(), compared.end(), origin.role) == 0) continue;
      const auto& [first, whose] = known.try_emplace(origin.role, origin, its).first->second;
      if (first.sha256 != origin.sha256)
        found.push_back({contradiction(file, origin, whose, first), file.path});
    }
  }
  return found;
}

std::vector<StaleFile> stale_files(const CellSettings& cell, bool with_error_map) {
  std::vector<MadeFile> files = made_files(cell, with_error_map);
  files.erase(std::remove_if(files.begin(), files.end(),
                             [](const MadeFile& file) { return !fs::exists(file.path); }),
              files.end());
  // Nothing is made from a map, a health file or an arm that was found.
  std::vector<Origin> present = origins_in(cell, calibration_files(cell, false));
  present.push_back(arm_origin(cell));
  return contradictions(files, present, values_of(kRoles));
}

void require_made_with(const MadeFile& file, const std::vector<Origin>& present, bool accepted) {
  std::vector<Role> compared;
  compared.reserve(present.size());
  for (const Origin& origin : present) compared.push_back(origin.role);
  accept_stale(contradictions({file}, present, compared), accepted);
}

void require_belonging(const std::vector<StaleFile>& stale) {
  Faults faults;
  for (const StaleFile& file : stale) faults.add(file);
  faults.throw_if_any();
}

std::vector<std::string> accept_stale(const std::vector<StaleFile>& stale, bool accepted) {
  if (!accepted) require_belonging(stale);
  std::vector<std::string> texts;
  texts.reserve(stale.size());
  for (const StaleFile& file : stale) texts.push_back(file.text());
  for (const std::string& text : texts) spdlog::warn("accepted: " + text);
  return texts;
}

}  // namespace planar
