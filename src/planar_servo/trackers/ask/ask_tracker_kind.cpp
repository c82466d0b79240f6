#include "planar_servo/trackers/ask/ask_tracker_kind.h"

#include "planar_servo/io/fields.h"
#include "planar_servo/trackers/ask/asked_tracker.h"
#include "planar_servo/trackers/stream/stream_settings.h"

namespace planar {

std::shared_ptr<const DeviceDetails> AskTrackerKind::read(Fields& tracker) const {
  auto details = std::make_shared<StreamDetails>();
  read_number_keys(tracker, details->dialect);
  return details;
}

std::shared_ptr<Tracker> AskTrackerKind::open(const CellSettings& cell,
                                              const std::shared_ptr<VirtualCell>& /*world*/) const {
  return std::make_shared<AskedTracker>(stream_details(cell).dialect);
}

std::vector<Finding> AskTrackerKind::examine(const CellSettings& /*cell*/) const {
  return {{Finding::Verdict::kWell, "tracker",
           "planar-record asks at its terminal for each monument and place"}};
}

}  // namespace planar
