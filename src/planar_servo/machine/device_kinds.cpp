#include "planar_servo/machine/device_kinds.h"

#include "planar_servo/cameras/aravis/aravis_kind.h"
#include "planar_servo/cameras/files/files_kind.h"
#include "planar_servo/drives/grbl/grbl_kind.h"
#include "planar_servo/drives/tic/tic_kind.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/machine/virtual_kinds.h"
#include "planar_servo/trackers/ask/ask_tracker_kind.h"
#include "planar_servo/trackers/file/file_tracker_kind.h"
#include "planar_servo/trackers/tcp/tcp_tracker_kind.h"

namespace planar {
namespace {

template <typename Kind>
const Kind* one() {
  static const Kind kind;
  return &kind;
}

}  // namespace

const DeviceKinds& device_kinds() {
  static const DeviceKinds kinds{
      {
          one<VirtualCameraKind>(),
          one<FilesKind>(),
          one<AravisKind>(),
      },
      {
          one<VirtualDriveKind>(),
          one<TicKind>(),
          one<GrblKind>(),
      },
      {
          one<NoTrackerKind>(),
          one<VirtualTrackerKind>(),
          one<FileTrackerKind>(),
          one<TcpTrackerKind>(),
          one<AskTrackerKind>(),
      },
  };
  return kinds;
}

CellSettings read_cell(const std::filesystem::path& path) {
  return read_cell(path, device_kinds());
}

}  // namespace planar
