#include "planar_servo/doctor/new_cell.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/core/error.h"
#include "planar_servo/doctor/new_cell_text.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar {
namespace {

/// Motor angles behind the gears where the arm stands at the new cell's `home_deg`.
constexpr double kMarks_deg[] = {0.0, 60.0, -60.0};

const DriveKind* kind_named(const std::string& name) {
  const std::vector<const DriveKind*>& kinds = device_kinds().drives;
  const auto found = std::find_if(kinds.begin(), kinds.end(),
                                  [&](const DriveKind* kind) { return kind->name() == name; });
  return found == kinds.end() ? nullptr : *found;
}

std::string new_cell_text(const DriveKind& kind) {
  const bool is_virtual = kind.is_virtual();
  std::string text = kNewCellHead;
  text += is_virtual ? kNewVirtualCamera : kNewRealCamera;
  text += kNewCellMiddle;
  for (std::size_t i = 0; i < 3; ++i) {
    text += new_drive_head(static_cast<int>(i) + 1, kind.name());
    text += kind.new_keys(i, kMarks_deg[i]) + kNewMotor;
  }
  text += kNewServo;
  text += is_virtual ? kNewVirtualTracker : kNewRealTracker;
  text += kNewCellTail;
  if (is_virtual) text += kNewTruth;
  return text;
}

}  // namespace

std::vector<std::string> new_cell_drives() {
  std::vector<std::string> names;
  for (const DriveKind* kind : device_kinds().drives) names.push_back(kind->name());
  return names;
}

void write_new_cell(const std::filesystem::path& path, const std::string& drives) {
  const DriveKind* const kind = kind_named(drives);
  if (kind == nullptr)
    throw InputError(fmt::format("drives of kind '{}' are not known; name one of {}", drives,
                                 fmt::join(new_cell_drives(), ", ")));
  if (std::filesystem::exists(std::filesystem::symlink_status(path)))
    throw InputError(path.string() + ": exists already; name another file or remove it first");
  require_writable(path, "cell");
  write_file(path, new_cell_text(*kind));
}

}  // namespace planar
