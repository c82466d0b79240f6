#include "planar_servo/console/arm_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "planar_servo/base/core/threads.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/certificate/certificate_report.h"
#include "planar_servo/console/json_values.h"
#include "planar_servo/files/drawings/gcode.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/work/record/recorder.h"
#include "planar_servo/work/run/path_report.h"

namespace planar {
namespace {

std::string words_of(const Certificate& certificate) {
  if (!certificate.run.ended_by.empty())
    return fmt::format(
        "{}; the cell is in doubt and no further move was made: mend it, then begin the same "
        "certificate again to continue",
        certificate.run.ended_by);
  const CellAccuracy& accuracy = certificate.accuracy;
  std::string words = fmt::format("{} of {} moves reached and judged by the {}", accuracy.judged,
                                  accuracy.moves, name_in(kJudgeKinds, certificate.run.judge));
  for (const auto& [name, figure] : worst_pose_figures(accuracy))
    words += fmt::format("; {} {}", name, figure);
  return words;
}

void require_size(const CertificateSize& size) {
  const auto require = [](const char* what, int count, int least, int most) {
    if (count < least || count > most)
      throw InputError(
          {fmt::format("is {}", count), fmt::format("take {} to {}", least, most), what});
  };
  require("cycles", size.cycles, CertificateSize::kLeastCycles, CertificateSize::kMostCycles);
  require("targets", size.targets, 1, CertificateSize::kMostTargets);
}

namespace fs = std::filesystem;

constexpr char kPath[] = "the path";
std::size_t whole_mm(double metres) {
  return static_cast<std::size_t>(std::lround(mm(metres)));
}

/// Returns how a path went, in words: as it was seen, or else why its end was not reached.
std::string words_of(const PathSpeedResult& result) {
  std::string words = fmt::format("{:g} mm/s by {}: {}", mm(result.speed_m_s),
                                  name_in(kGuidances, result.guidance), name(result.status));
  if (!result.reason.empty()) return words + ": " + result.reason;
  if (!result.own_view) return words;
  const Summary& across = result.own_view->across_m;
  return words + fmt::format(", {:.4f} mm off the path in the mean, {:.4f} mm at most, as seen",
                             mm(across.mean), mm(across.max));
}

}  // namespace

int begin_recording(ConsoleJobs& jobs, const RecordingOrder& order, StopsKnown known) {
  CellJobs::require_name(order.plan, "-_.", "plan");
  CellJobs::require_name(order.out, "-_.", "out");
  RecordRequest wanted;
  wanted.cell = jobs.cell.settings();
  wanted.plan = read_plan(jobs.cell.folder() / order.plan, wanted.cell.tool_orientation);
  wanted.recording = jobs.cell.folder() / order.out;
  wanted.on_bad_reading = value_in(kBadReadings, order.on_bad_reading, "on_bad_reading");
  if (!order.board.empty()) wanted.board = parse_board(order.board, BoardUse::kShape);
  const auto record_all = [&jobs, wanted](CellDevices& devices, const CellJobs::Stop& stop,
                                          const CellJobs::Begun& begun) -> CellJobs::Ending {
    bool is_begun = false;
    const auto begin_once = [&] {
      if (!std::exchange(is_begun, true)) begun(0, wanted.plan.size());
    };
    RecordRequest request = wanted;
    request.stop = stop;
    request.may_home = CellJobs::refuse_homing;
    request.person = jobs.person.attend(stop, begin_once);
    request.watch = [&](const RecordingState& recording) {
      begin_once();
      jobs.board.change([&](CellState& state) {
        state.recording = recording;
        state.job->done = static_cast<std::size_t>(
            std::count_if(recording.places.begin(), recording.places.end(),
                          [](const auto& place) { return place.mark != PlaceMark::kToDo; }));
      });
    };
    const RecordReport report = record(request, devices);
    begin_once();
    const std::string skipped =
        report.skipped.empty() ? "" : fmt::format(", {} left out", report.skipped.size());
    return {fmt::format("{} positions recorded ({} were there before){}", report.recorded,
                        report.present, skipped),
            report.skipped.empty()};
  };
  return jobs.places.begin(Doing::kRecording, "record", order.out, known, record_all);
}

int begin_certificate(ConsoleJobs& jobs, const std::string& name, const CertificateSize& size,
                      StopsKnown known) {
  require_size(size);
  const fs::path out = jobs.places.folder(name);
  const auto work = [&jobs, size, out](CellDevices& devices, const CellJobs::Stop& stop,
                                       const CellJobs::Begun& begun) -> CellJobs::Ending {
    CertificateRequest request{jobs.places.request(stop), size, jobs.places.watch()};
    request.servo.folder.path = out;
    devices.tracker().ask_of(jobs.person.attend(stop, [] {}));
    const AtEnd given_back([&] { devices.tracker().ask_of(std::make_shared<Terminal>()); });
    const auto lend = [&](const CellSettings& /*cell*/) {
      return std::shared_ptr<CellDevices>(&devices, [](CellDevices* /*lent*/) {});
    };
    bool is_begun = false;
    const Certificate certificate =
        certificate_of(run_certificate(request, lend, [&](std::size_t done, std::size_t all) {
          if (!std::exchange(is_begun, true)) return begun(done, all);
          jobs.places.show_progress(done, all);
        }));
    if (!is_begun) begun(certificate.run.moves.size(), certificate.run.moves.size());
    write_certificate(certificate);
    const std::string words = words_of(certificate);
    jobs.places.hold(certificate.run.ended_by.empty() ? "" : words);
    return {words, certificate.all_count()};
  };
  return jobs.places.begin(Doing::kRunning, "certificate", name, known, work);
}

void PathJob::load(const std::string& csv) {
  std::optional<Table> table;
  if (csv.find_first_not_of(" \r\n") != csv.npos) {
    const double phi = cell_.settings().tool_orientation;
    table.emplace(Table{csv, is_gcode(csv) ? path_of(read_gcode(csv, kPath), phi, kPath)
                                           : read_path({kPath, csv}, phi)});
    require_followable(cell_.calibrated(), {kPath, table->path, {}, {kSlowest_m_s}});
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  table_ = std::move(table);
}

nlohmann::ordered_json PathJob::json() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!table_)
    return {{"csv", ""}, {"length_mm", 0.0}, {"places_mm", nlohmann::ordered_json::array()}};
  return {{"csv", table_->csv},
          {"length_mm", json_number(mm(table_->path.length_m()))},
          {"places_mm", json_list(drawn_places(table_->path), json_mm)}};
}

int PathJob::begin(const std::string& name, const std::vector<double>& speeds_mm_s,
                   const std::vector<Guidance>& guidances, StopsKnown known) {
  const fs::path out = jobs_.folder(name);
  std::optional<Table> table;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    table = table_;
  }
  if (!table) throw InputError({"there is no path", "load one", "", Cause::kMissing});
  PathRequest path{kPath, table->path, guidances, path_speeds(speeds_mm_s)};
  if (speeds_mm_s.empty() || guidances.empty())
    throw InputError({"it is to be followed no time", "name a speed and what guides it", kPath});
  require_followable(cell_.calibrated(), path);
  path.file = out / (is_gcode(table->csv) ? "path.nc" : "path.csv");
  return jobs_.begin(Doing::kRunning, "path", name, known,
                     [=, csv = table->csv](CellDevices& devices, const CellJobs::Stop& stop,
                                           const CellJobs::Begun& begun) {
                       ServoRequest request = jobs_.request(stop);
                       request.folder.path = out;
                       return follow(request, path, csv, devices, begun);
                     });
}

CellJobs::Ending PathJob::follow(const ServoRequest& request, const PathRequest& path,
                                 const std::string& csv, CellDevices& devices,
                                 const CellJobs::Begun& begun) {
  std::vector<std::string> words;
  PathRun run(request, path, devices,
              [&](const PathLookRow& row) { show(row, path, words.size()); });
  const std::size_t passes = path.guidances.size() * path.speeds_m_s.size();
  begun(0, whole_mm(static_cast<double>(passes) * path.path.length_m()));
  write_file(path.file, csv);
  const bool reached = follow_path(run, path, [&](const PathSpeedResult& result) {
    words.push_back(words_of(result));
    jobs_.tell_result(path_list(path, {result}).json()["speeds"][0]);
  });
  write_path_run(request, path, run);
  jobs_.hold(run.ended_by().value_or(""));
  return {fmt::format("{}", fmt::join(words, "; ")), reached};
}

void PathJob::show(const PathLookRow& row, const PathRequest& path, std::size_t passed) {
  jobs_.show_look(row.look.measurement, row.look.measurement.tip.p);
  const double length_m = path.path.length_m();
  const std::size_t passes = path.guidances.size() * path.speeds_m_s.size();
  double left_s = (length_m - row.look.along_now_m) / row.speed_m_s;
  for (std::size_t i = passed + 1; i < passes; ++i)
    left_s += length_m / path.speeds_m_s[i % path.speeds_m_s.size()];
  jobs_.show_progress(whole_mm(static_cast<double>(passed) * length_m + row.look.along_now_m),
                      whole_mm(static_cast<double>(passes) * length_m), left_s);
}

}  // namespace planar
