#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// What a file, or a block of a cell file, is to the files made from it.
enum class Role {
  kCamera,
  kFrames,  ///< frames.csv of the recording
  kLamps,
  kTracker,
  kWorkplane,
  kTool,
  kPairs,
  kErrorMap,
  kHealth,
  kArmFound,
  kLays,
  kBar,         ///< the marks of a bar of certified length
  kMarks,       ///< those of the base
  kLampLayout,  ///< `lamps` of the cell file, without the method
  kImageSize,   ///< `camera` of the cell file, its size only
  kDatum,       ///< `datum` of the cell file
  kDrawing,     ///< of a workpiece
  kWork,
  kToolTip,
  kArm,  ///< `arm` of the cell file: links, sense, elbow and coupling
};

/// All roles with the words that files have for them.
constexpr Named<Role> kRoles[] = {{Role::kCamera, "camera"},
                                  {Role::kFrames, "frames"},
                                  {Role::kLamps, "lamps"},
                                  {Role::kTracker, "tracker"},
                                  {Role::kWorkplane, "workplane"},
                                  {Role::kTool, "tool"},
                                  {Role::kPairs, "pairs"},
                                  {Role::kErrorMap, "error_map"},
                                  {Role::kLampLayout, "cell_lamps"},
                                  {Role::kImageSize, "cell_image_size"},
                                  {Role::kDatum, "cell_datum"},
                                  {Role::kHealth, "health"},
                                  {Role::kDrawing, "drawing"},
                                  {Role::kWork, "work"},
                                  {Role::kToolTip, "tool_tip"},
                                  {Role::kArmFound, "arm_found"},
                                  {Role::kArm, "cell_arm"},
                                  {Role::kLays, "lays"},
                                  {Role::kBar, "bar"},
                                  {Role::kMarks, "marks"}};

/// Holds one thing that a file was made from.
struct Origin {
  Role role{Role::kCamera};
  std::string name;    ///< name of the file, and of the block within a cell file
  std::string sha256;  ///< of its content; see content_sha256()
};

/// Returns the first of these origins that has this role; null where there is none.
const Origin* find_role(const std::vector<Origin>& origins, Role role);

/// Names a file that says what it was made from.
struct MadeFile {
  Role role{Role::kCamera};
  std::filesystem::path path;
};

const char* program_for(Role role);

/// Returns the cell's calibration files in the order of their making, whether they exist or not.
std::vector<MadeFile> calibration_files(const CellSettings& cell, bool with_error_map);

/// Returns these, the health file and the arm that was found, as far as the cell names them.
std::vector<MadeFile> made_files(const CellSettings& cell, bool with_error_map);

/// Returns the origin that this file is for what is made from it. Throws InputError when it cannot
/// be read.
Origin origin_of(const MadeFile& file);

/// Returns the same for a file that is yet to be written with this text.
Origin origin_of(const MadeFile& file, const std::string& text);

/// Returns the blocks of a cell that calibration files are made from.
std::vector<Origin> origins_in(const CellSettings& cell);

/// Returns the block of a cell that only health.yaml and arm.yaml are made from.
Origin arm_origin(const CellSettings& cell);

/// Returns the blocks of a cell and those of these files that exist.
std::vector<Origin> origins_in(const CellSettings& cell, const std::vector<MadeFile>& files);

/// Returns what a file says it was made from. A file of another program says nothing.
std::vector<Origin> read_origins(const std::filesystem::path& path);

/// Returns the program that made a YAML file and when, such as "planar-pair-tracker 0.1.0,
/// 2026-11-22T05:28:39Z", and when it was edited by hand. Empty for a file that does not say it.
std::string read_maker(const std::filesystem::path& path);

/// Returns `made_from` followed by what `file` says it was made from, as far as that has other
/// roles.
std::vector<Origin> with_origins_of(std::vector<Origin> made_from,
                                    const std::filesystem::path& file);

/// Returns the origins as YamlWriter::add_inputs() and csv_remarks() take them.
std::vector<InputRecord> input_records(const std::vector<Origin>& origins);

/// Returns the origins as comment lines of a table.
std::vector<std::string> csv_remarks(const std::vector<Origin>& origins);

/// Returns what follows `key` in a comment line of this key before a table's rows; empty where
/// there is none.
std::string remark_in(const std::filesystem::path& table, const std::string& key);

/// Returns a table with a comment line `# rows: SHA256` of its header and rows.
std::string with_row_hash(const std::string& table);

/// Returns true when a table has such a line and its header and rows are no longer those.
bool has_changed_rows(const std::filesystem::path& table);

/// Names a file that does not belong to the others, and why.
struct StaleFile : Refusal {
  std::filesystem::path path;
};

/// Returns a refusal, with the program that makes it, for each of these files that does not exist.
std::vector<StaleFile> missing_files(const std::vector<MadeFile>& files);

/// Returns a refusal for every origin of these files that differs from what is `present`, or from
/// the same origin of a file before it. It names both and the program to run again. Only these
/// roles are compared.
std::vector<StaleFile> contradictions(const std::vector<MadeFile>& files,
                                      const std::vector<Origin>& present,
                                      const std::vector<Role>& compared);

/// Returns contradictions() of the cell's calibration files, as far as they exist.
std::vector<StaleFile> stale_files(const CellSettings& cell, bool with_error_map);

/// Throws InputError naming what of this file's origins is no longer `present`, with roles that are
/// present; where that is accepted, it is only logged.
void require_made_with(const MadeFile& file, const std::vector<Origin>& present, bool accepted);

/// Throws InputError with these refusals, unless there are none.
void require_belonging(const std::vector<StaleFile>& stale);

/// Returns these refusals as sentences, and shows them in the log. Throws InputError with them
/// unless they are accepted.
std::vector<std::string> accept_stale(const std::vector<StaleFile>& stale, bool accepted);

}  // namespace planar
