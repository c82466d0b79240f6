#include "planar_servo/console/recording_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "planar_servo/console/json_values.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/work/record/recorder.h"

namespace planar {
namespace {

constexpr std::size_t kMostFileName = 64;

void require_file_name(const std::string& name, const char* where) {
  constexpr char kAllowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.";
  if (name.empty() || name.size() > kMostFileName || name[0] == '.' ||
      name.find_first_not_of(kAllowed) != name.npos)
    throw InputError({fmt::format("is '{}'", name),
                      fmt::format("take up to {} letters, digits, - . and _", kMostFileName),
                      where});
}

RecordingState state_of(const RecordView& view) {
  RecordingState state{view.title, view.now, view.counts, {}, {}, view.here_B};
  for (const RecordView::Place& place : view.places)
    state.places.push_back({place.p_B, place.mark == PlaceMark::kToDo   ? "to_do"
                                       : place.mark == PlaceMark::kDone ? "done"
                                                                        : "left_out"});
  for (const RecordView::Point& monument : view.monuments)
    state.monuments.emplace_back(monument.id, monument.p_B);
  return state;
}

}  // namespace

int RecordingJob::begin(const RecordingOrder& order, StopsKnown known) {
  require_file_name(order.plan, "plan");
  require_file_name(order.out, "out");
  RecordRequest wanted;
  wanted.cell = cell_.settings();
  wanted.plan = read_plan(cell_.folder() / order.plan, wanted.cell.tool_orientation);
  wanted.recording = cell_.folder() / order.out;
  wanted.on_bad_reading = value_in(kBadReadings, order.on_bad_reading, "on_bad_reading");
  if (!order.board.empty()) wanted.board = parse_board(order.board, BoardUse::kShape);
  const auto record_all = [this, wanted](CellDevices& devices, const CellJobs::Stop& stop,
                                         const CellJobs::Begun& begun) -> CellJobs::Ending {
    bool is_begun = false;
    const auto begin_once = [&] {
      if (!std::exchange(is_begun, true)) begun(0, wanted.plan.size());
    };
    RecordRequest request = wanted;
    request.stop = stop;
    const auto at_page = std::make_shared<PageOperator>(board_, stop, begin_once);
    request.person = at_page;
    request.watch = [&](const RecordView& view) {
      begin_once();
      board_.change([&](CellState& state) {
        state.recording = state_of(view);
        state.job->done = static_cast<std::size_t>(
            std::count_if(view.places.begin(), view.places.end(),
                          [](const auto& place) { return place.mark != PlaceMark::kToDo; }));
      });
    };
    const auto seated = seat_.take(at_page);
    const RecordReport report = record(request, devices);
    begin_once();
    const std::string skipped =
        report.skipped.empty() ? "" : fmt::format(", {} left out", report.skipped.size());
    return {fmt::format("{} positions recorded ({} were there before){}", report.recorded,
                        report.present, skipped),
            report.skipped.empty()};
  };
  return jobs_.begin(Doing::kRecording, "record", order.out, known, record_all);
}

}  // namespace planar
