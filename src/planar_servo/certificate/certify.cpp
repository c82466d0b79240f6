#include "planar_servo/certificate/certify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/work/run/resumed_run.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

fs::path cycles_file(const CertificateRequest& request) {
  return request.servo.out / "cycles.csv";
}

/// Returns the settings that decide the moves, as comment lines. The calibration's files are those
/// of results.csv.
std::string header_of(const CertificateRequest& request, JudgeKind judge) {
  return cycles_header({fmt::format("# cycles: {}", request.size.cycles),
                        fmt::format("# targets: {}", request.size.targets),
                        fmt::format("# judge: {}", name_in(kJudgeKinds, judge)),
                        fmt::format("# cell: {}", content_sha256(request.servo.cell.file))});
}

/// Throws InputError when the folder's moves were made with other calibration files.
void require_same_files(ServoRequest servo) {
  servo.resume = true;
  results_so_far(servo);
}

/// Returns the moves that the folder holds. Throws InputError when they are of another certificate.
std::vector<JudgedMove> moves_so_far(const CertificateRequest& request, const std::string& header) {
  const fs::path file = cycles_file(request), results = request.servo.out / "results.csv";
  if (!fs::exists(file)) {
    if (fs::exists(results) && !read_results(results).empty())
      throw InputError({"belongs to no certificate", "name another folder", results});
    return {};
  }
  drop_torn_line(file, header);
  const std::string text = read_file(file);
  if (text.compare(0, header.size(), header) == 0) {
    require_same_files(request.servo);
    return read_cycles(file);
  }
  throw InputError(
      {"was begun with other --cycles or --targets, with another judge or before the cell file was "
       "changed; its first lines say with which",
       "give the same ones to continue, or name another folder", file});
}

/// Returns the objections to the cell's files. Throws InputError unless they are accepted.
std::vector<std::string> accepted_words(const CertificateRequest& request,
                                        const VisionCalibration& vision) {
  const std::vector<StaleFile> stale = stale_files(request.servo.cell, true);
  if (!request.servo.accept_stale) require_belonging(stale);
  std::vector<std::string> words;
  words.reserve(stale.size());
  for (const StaleFile& file : stale) words.push_back(file.refusal.text());
  if (const auto map = accept_map(request.servo.cell, vision, request.servo.accept_map))
    words.push_back(request.servo.cell.error_map.string() + ": " + *map);
  return words;
}

/// Drives a cell through the moves of its certificate.
class CertificateDriver {
 public:
  CertificateDriver(const CertificateRequest& request, CellDevices& devices)
      : phi_d_(request.servo.cell.tool_orientation),
        watch_(request.watch),
        run_(request.servo, devices, [this](const ServoSight& sight) { watch(sight); }) {}

  ServoRun& run() { return run_; }

  /// Makes a move from its start and has its end judged. A move whose start is refused is not made.
  JudgedMove make(const CertificateMove& move, Judge& judge) {
    JudgedMove made;
    made.move = move;
    made.utc = utc_now();
    if (move.p_before && arm_at_ != move.p_before) {
      made.status = go(move.id + ".from", *move.p_before).status;
      if (run_.ended_by() || made.status == ServoStatus::kRefused) return made;
    }
    const TargetResult& result = go(move.id, move.p_d);
    made.status = result.status;
    made.seconds = result.seconds;
    made.utc = utc_now();
    made.landing_own = result.before_own;
    made.error_own = result.after_own;
    if (!last_ || !last_->measurement.ok()) return made;
    made.sigma_vision = last_->measurement.sigma_vision_m;
    made.stop_below = last_->stop_below_m;
    const JudgedTip tip = judge.judge(move.id, last_->standing());
    if (!tip.p) return made;
    made.judge_sigma = std::hypot(tip.sigma, judge.common_sigma());
    made.error = *tip.p - move.p_d;
    if (tip.phi) made.turn_error = wrap_angle(*tip.phi - phi_d_);
    return made;
  }

 private:
  void watch(const ServoSight& sight) {
    last_ = sight.step;
    if (watch_) watch_(sight);
  }

  /// Moves to a place. A name that a killed program has used already gets a stroke.
  TargetResult go(std::string id, const Eigen::Vector2d& p) {
    while (run_.has(id)) id += '\'';
    last_.reset();
    TargetResult result = run_.move_to({id, p, std::nullopt});
    if (result.status != ServoStatus::kRefused) arm_at_ = p;
    return result;
  }

  double phi_d_;
  ServoRun::Observer watch_;
  std::optional<ServoStep> last_;          ///< of the move that is being made
  std::optional<Eigen::Vector2d> arm_at_;  ///< where this program has sent the arm
  ServoRun run_;
};

std::vector<CertificateMove> moves_left(const CertificateRun& certificate) {
  std::set<std::string> made;
  for (const JudgedMove& move : certificate.moves) made.insert(move.move.id);
  std::vector<CertificateMove> left;
  for (CertificateMove& move :
       certificate_moves(certificate.places, certificate.request.size.cycles))
    if (made.count(move.id) == 0) left.push_back(std::move(move));
  return left;
}

void make_moves(CertificateRun& certificate, const std::vector<CertificateMove>& moves,
                const std::string& header, CellDevices& devices,
                const std::function<void(std::size_t done, std::size_t all)>& progress) {
  CertificateRequest request = certificate.request;
  request.servo.resume = fs::exists(request.servo.out / "results.csv");
  CertificateDriver driver(request, devices);
  const std::size_t all = certificate.moves.size() + moves.size();
  if (progress) progress(certificate.moves.size(), all);
  const auto judge = make_judge(certificate.judge, request.servo.cell, certificate.vision.tool,
                                devices, request.servo.out / "tracker.csv", request.servo.stop);
  GrowingFile table(cycles_file(request), header);
  for (const CertificateMove& move : moves) {
    const JudgedMove made = driver.make(move, *judge);
    if (driver.run().ended_by()) {
      certificate.ended_by = *driver.run().ended_by();
      return;
    }
    certificate.moves.push_back(made);
    table.append(cycle_line(made), Durability::kPowerLoss);
    if (progress) progress(certificate.moves.size(), all);
  }
}

}  // namespace

CertificateRun run_certificate(
    const CertificateRequest& request, const OpenDevices& open,
    const std::function<void(std::size_t done, std::size_t all)>& progress) {
  const CellSettings& cell = request.servo.cell;
  VisionCalibration vision = read_vision(cell, true);
  const JudgeKind judge = judge_of(cell, vision.tool);
  const std::string header = header_of(request, judge);
  CertificateRun certificate{request, std::move(vision)};
  certificate.judge = judge;
  certificate.moves = moves_so_far(request, header);
  certificate.accepted = accepted_words(request, certificate.vision);
  certificate.places =
      find_test_places(cell, certificate.vision, static_cast<std::size_t>(request.size.targets));
  const std::vector<CertificateMove> left = moves_left(certificate);
  if (left.empty()) return certificate;
  const auto devices = open(cell);
  make_moves(certificate, left, header, *devices, progress);
  certificate.moves = read_cycles(cycles_file(request));  // to its digits, as when it is read again
  return certificate;
}

}  // namespace planar
