#include "planar_servo/trackers/file/file_tracker_kind.h"

#include "planar_servo/io/fields.h"
#include "planar_servo/trackers/file/file_feed.h"
#include "planar_servo/trackers/stream/stream_doctor.h"
#include "planar_servo/trackers/stream/stream_settings.h"
#include "planar_servo/trackers/stream/stream_tracker.h"

namespace planar {
namespace {

/// Paths in a cell file count from its own folder.
std::filesystem::path path_of(const CellSettings& cell) {
  return cell.file.parent_path() / stream_details(cell).source;
}

}  // namespace

std::shared_ptr<const DeviceDetails> FileTrackerKind::read(Fields& tracker) const {
  auto details = std::make_shared<StreamDetails>();
  tracker.text("path", details->source);
  read_dialect(tracker, details->dialect);
  return details;
}

std::shared_ptr<Tracker> FileTrackerKind::open(
    const CellSettings& cell, const std::shared_ptr<VirtualCell>& /*world*/) const {
  const TrackerDialect& dialect = stream_details(cell).dialect;
  auto stream = std::make_shared<ReadingStream>(path_of(cell).string(), dialect);
  auto feed = std::make_unique<FileFeed>(path_of(cell), *stream);
  return std::make_shared<StreamTracker>(cell, dialect.has_ids(), stream, std::move(feed));
}

std::vector<Finding> FileTrackerKind::examine(const CellSettings& cell) const {
  return examine_stream(path_of(cell).string(), cell, [&](ReadingStream& stream) {
    return std::make_unique<FileFeed>(path_of(cell), stream);
  });
}

}  // namespace planar
