#include "planar_servo/machine/trackers/tracker_kinds.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/fields.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/machine/trackers/line_feeds.h"
#include "planar_servo/machine/trackers/stream_tracker.h"

namespace planar {
namespace {

constexpr Named<bool> kYesOrNo[] = {{true, "true"}, {false, "false"}};
constexpr double kListen_s = 3.0;
// No tracker measures nearer or farther.
constexpr double kNearest_m = 0.05;
constexpr double kFarthest_m = 100.0;

/// Reads the optional keys `separator`, `decimal_comma` and `unit`.
void read_number_keys(Fields& tracker, TrackerDialect& dialect) {
  if (tracker.given("decimal_comma", false)) {
    tracker.choice("decimal_comma", dialect.csv.decimal_comma, kYesOrNo);
    if (dialect.csv.decimal_comma) dialect.csv.separator = ';';
  }
  if (tracker.given("separator", false)) {
    std::string separator;
    tracker.text("separator", separator);
    const bool one = separator.size() == 1;
    tracker.check(one && !(dialect.csv.decimal_comma && separator == ","),
                  {"tracker.separator is '" + separator + "'",
                   "one character is needed, and another than ',' with decimal_comma"},
                  "separator");
    if (one) dialect.csv.separator = separator[0];
  }
  if (tracker.given("unit", false)) tracker.choice("unit", dialect.unit, kTrackerUnits);
}

/// Reads the keys of read_number_keys() and the optional map `columns`.
void read_dialect(Fields& tracker, TrackerDialect& dialect) {
  read_number_keys(tracker, dialect);
  if (!tracker.given("columns", false)) return;
  tracker.map("columns", [&] {
    for (const auto& [word, column] : tracker_columns())
      if (tracker.given(word, false)) tracker.text(word, dialect.csv.renamed_columns[column]);
  });
}

Finding tracker_finding(Finding::Verdict verdict, const std::string& what,
                        const std::string& remedy = "") {
  return {{what, remedy, "tracker", Cause::kDevice}, verdict};
}

Finding silence(const ReadingStream& stream) {
  const std::string loss = stream.loss();
  return tracker_finding(
      Finding::Verdict::kDoubtful,
      fmt::format("{} is there, but no line came in {} s{}", stream.source(), kListen_s,
                  loss.empty() ? "" : ": " + loss),
      stream.has_columns()
          ? "start a measurement in the tracker's program"
          : "start a measurement in the tracker's program; its columns are not seen yet");
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

/// Opens a tracker whose program writes lines. `Feed` feeds them from a file or an address.
template <typename Feed>
std::shared_ptr<Tracker> open_stream(const std::string& source, const CellSettings& cell) {
  const TrackerDialect& dialect = stream_details(cell).dialect;
  auto stream = std::make_shared<ReadingStream>(source, dialect);
  auto feed = std::make_unique<Feed>(source, *stream);
  return std::make_shared<StreamTracker>(cell, dialect.has_ids(), stream, std::move(feed),
                                         std::make_shared<Terminal>());
}

/// Examines such a tracker: whether lines come, are readings, and tell lengths that a tracker can
/// measure.
template <typename Feed>
std::vector<Finding> examine_stream(const std::string& source, const CellSettings& cell) {
  ReadingStream stream(source, stream_details(cell).dialect);
  try {
    const Feed feed(source, stream);
    stream.forget();
    const std::optional<StreamEvent> event = stream.next(kListen_s);
    return {event ? verdict_of(*event, stream) : silence(stream)};
  } catch (const WorkError& error) {
    return {faulty("tracker", error.refusal())};
  }
}

/// Paths in a cell file are relative to its own folder.
std::string path_of(const CellSettings& cell) {
  return (cell.file.parent_path() / stream_details(cell).source).string();
}

}  // namespace

std::optional<bool> keeps_reading(Operator& person, const std::string& id) {
  if (!person.is_attended()) return std::nullopt;
  for (;;) {
    const std::string word = person.ask(
        fmt::format("press Enter to read '{}' again, or type k to keep this reading: ", id));
    if (word.empty()) return false;
    if (word == "k") return true;
  }
}

AskedTracker::AskedTracker(TrackerDialect dialect, std::shared_ptr<Operator> person)
    : dialect_(std::move(dialect)), person_(std::move(person)) {
  dialect_.csv.renamed_columns = {{"x_mm", "1"}, {"y_mm", "2"}, {"z_mm", "3"}};
}

TrackerAnswer AskedTracker::measure_tool(const std::string& place) {
  return ask(fmt::format("measure the reflector on the tool at '{}'", place));
}

TrackerAnswer AskedTracker::measure_monument(const std::string& id) {
  return ask(fmt::format("place the reflector on '{}', measure it", id));
}

void AskedTracker::await_tool() {
  if (person_->is_attended())
    person_->ask("place the reflector back on the tool and press Enter; the arm will move: ");
}

TrackerAnswer AskedTracker::ask(const std::string& what) {
  const std::string question = fmt::format(
      "{} and press Enter, or type x{}y{}z in {}; s skips, r repeats: ", what,
      dialect_.csv.separator, dialect_.csv.separator, name_in(kTrackerUnits, dialect_.unit));
  for (std::string hint;;) {
    const std::string word = person_->ask(hint + question);
    if (word.empty()) return {TrackerStatus::kElsewhere};
    if (word == "s") return {TrackerStatus::kSkipped};
    if (word == "r") return {TrackerStatus::kRepeat};
    try {
      if (const auto reading = TrackerLines("typed", dialect_).next(word))
        return TrackerAnswer::of({SteadyClock().now_s(), reading->p_L});
    } catch (const InputError& error) {
      hint = fmt::format("{}\n", error.what());
    }
  }
}

const StreamDetails& stream_details(const CellSettings& cell) {
  return details_of<StreamDetails>(cell.tracker);
}

std::shared_ptr<const DeviceDetails> FileTrackerKind::read(Fields& tracker) const {
  auto details = std::make_shared<StreamDetails>();
  tracker.text("path", details->source);
  read_dialect(tracker, details->dialect);
  return details;
}

std::shared_ptr<Tracker> FileTrackerKind::open(const CellSettings& cell) const {
  return open_stream<FileFeed>(path_of(cell), cell);
}

std::vector<Finding> FileTrackerKind::examine(const CellSettings& cell) const {
  return examine_stream<FileFeed>(path_of(cell), cell);
}

std::shared_ptr<const DeviceDetails> TcpTrackerKind::read(Fields& tracker) const {
  auto details = std::make_shared<StreamDetails>();
  tracker.text("address", details->source);
  tracker.check(details->source.empty() || !host_and_port(details->source).first.empty(),
                {"tracker.address is '" + details->source + "'",
                 "HOST:PORT is needed, such as 192.168.0.20:7000"},
                "address");
  read_dialect(tracker, details->dialect);
  return details;
}

std::shared_ptr<Tracker> TcpTrackerKind::open(const CellSettings& cell) const {
  return open_stream<TcpFeed>(stream_details(cell).source, cell);
}

std::vector<Finding> TcpTrackerKind::examine(const CellSettings& cell) const {
  return examine_stream<TcpFeed>(stream_details(cell).source, cell);
}

std::shared_ptr<const DeviceDetails> AskTrackerKind::read(Fields& tracker) const {
  auto details = std::make_shared<StreamDetails>();
  read_number_keys(tracker, details->dialect);
  return details;
}

std::shared_ptr<Tracker> AskTrackerKind::open(const CellSettings& cell) const {
  return std::make_shared<AskedTracker>(stream_details(cell).dialect, std::make_shared<Terminal>());
}

std::vector<Finding> AskTrackerKind::examine(const CellSettings& /*cell*/) const {
  return {{{"planar-record asks at its terminal for each monument and place", "", "tracker"},
           Finding::Verdict::kWell}};
}

}  // namespace planar
