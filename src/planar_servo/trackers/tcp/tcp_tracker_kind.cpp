#include "planar_servo/trackers/tcp/tcp_tracker_kind.h"

#include "planar_servo/io/fields.h"
#include "planar_servo/trackers/stream/stream_doctor.h"
#include "planar_servo/trackers/stream/stream_settings.h"
#include "planar_servo/trackers/stream/stream_tracker.h"
#include "planar_servo/trackers/tcp/tcp_feed.h"

namespace planar {

std::shared_ptr<const DeviceDetails> TcpTrackerKind::read(Fields& tracker) const {
  auto details = std::make_shared<StreamDetails>();
  tracker.text("address", details->source);
  tracker.check(details->source.empty() || !host_and_port(details->source).first.empty(),
                "tracker.address is '" + details->source +
                    "'; HOST:PORT is needed, such as 192.168.0.20:7000",
                "address");
  read_dialect(tracker, details->dialect);
  return details;
}

std::shared_ptr<Tracker> TcpTrackerKind::open(const CellSettings& cell,
                                              const std::shared_ptr<VirtualCell>& /*world*/) const {
  const StreamDetails& details = stream_details(cell);
  auto stream = std::make_shared<ReadingStream>(details.source, details.dialect);
  auto feed = std::make_unique<TcpFeed>(details.source, *stream);
  return std::make_shared<StreamTracker>(cell, details.dialect.has_ids(), stream, std::move(feed));
}

std::vector<Finding> TcpTrackerKind::examine(const CellSettings& cell) const {
  const std::string& address = stream_details(cell).source;
  return examine_stream(address, cell, [&](ReadingStream& stream) {
    return std::make_unique<TcpFeed>(address, stream);
  });
}

}  // namespace planar
