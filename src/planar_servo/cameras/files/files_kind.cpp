#include "planar_servo/cameras/files/files_kind.h"

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/core/error.h"
#include "planar_servo/devices/frame_source.h"

namespace planar {
namespace {

constexpr char kNoCamera[] = "camera.source is files, but stored pictures do not follow an arm";
constexpr char kRemedy[] =
    "name virtual or aravis; stored pictures are read by planar-locate-lamps IMAGE... and "
    "planar-calibrate-camera IMAGE...";

}  // namespace

std::string FilesKind::refusal() const {
  return std::string(kNoCamera) + "; " + kRemedy;
}

std::shared_ptr<FrameSource> FilesKind::open(const CellSettings& cell,
                                             const std::shared_ptr<VirtualCell>& /*world*/) const {
  throw InputError(cell.file.string() + ": " + refusal());
}

std::vector<Finding> FilesKind::examine(const CellSettings& /*cell*/) const {
  return {{Finding::Verdict::kDoubtful, "camera", kNoCamera, kRemedy}};
}

}  // namespace planar
