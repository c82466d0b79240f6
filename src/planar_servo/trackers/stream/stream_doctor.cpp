#include "planar_servo/trackers/stream/stream_doctor.h"

#include <fmt/format.h>

#include <optional>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/trackers/stream/stream_settings.h"

namespace planar {
namespace {

constexpr double kListen_s = 3.0;
// No tracker measures nearer or farther.
constexpr double kNearest_m = 0.05;
constexpr double kFarthest_m = 100.0;

Finding tracker_finding(Finding::Verdict verdict, const std::string& what,
                        const std::string& remedy = "") {
  return {verdict, "tracker", what, remedy};
}

Finding silence(const ReadingStream& stream) {
  const std::string loss = stream.loss();
  return tracker_finding(
      Finding::Verdict::kDoubtful,
      fmt::format("{} is there, but no line came in {} s{}", stream.source(), kListen_s,
                  loss.empty() ? "" : ": " + loss),
      stream.has_columns()
          ? "start a measurement in the tracker's program"
          : "start a measurement in the tracker's program; its columns are not seen "
            "yet");
}

Finding verdict_of(const StreamEvent& event, const ReadingStream& stream) {
  if (!event.reading)
    return tracker_finding(
        Finding::Verdict::kFaulty, event.fault,
        "clear the beam, or correct tracker.columns, separator and decimal_comma");
  const double range = event.reading->p_L.norm();
  const std::string seen =
      fmt::format("{}: reads a point {:.3f} m from the tracker", stream.source(), range);
  if (range >= kNearest_m && range <= kFarthest_m)
    return tracker_finding(Finding::Verdict::kWell, seen);
  return tracker_finding(Finding::Verdict::kDoubtful, seen,
                         range > kFarthest_m
                             ? "if the program writes millimetres, leave out tracker.unit or say mm"
                             : "if the program writes metres, say tracker.unit: m");
}

}  // namespace

std::vector<Finding> examine_stream(
    const std::string& source, const CellSettings& cell,
    const std::function<std::unique_ptr<StreamFeed>(ReadingStream&)>& feed) {
  ReadingStream stream(source, stream_details(cell).dialect);
  try {
    const std::unique_ptr<StreamFeed> feeding = feed(stream);
    stream.forget();
    const std::optional<StreamEvent> event = stream.next(kListen_s);
    return {event ? verdict_of(*event, stream) : silence(stream)};
  } catch (const WorkError& error) {
    return {
        tracker_finding(Finding::Verdict::kFaulty, error.refusal().fault, error.refusal().remedy)};
  }
}

}  // namespace planar
