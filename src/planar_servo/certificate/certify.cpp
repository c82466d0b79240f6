#include "planar_servo/certificate/certify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/work/run/dry_run.h"
#include "planar_servo/work/run/run_files.h"

namespace planar {
namespace {

struct ApproachSide {
  const char* name;
  double x, y;
};

constexpr ApproachSide kSides[] = {{"+x", 1, 0}, {"-x", -1, 0}, {"+y", 0, 1}, {"-y", 0, -1}};
/// The standard's poses for vAP, by their index.
constexpr std::size_t kVariationPoses[] = {0, 1, 3};

/// Nodes of the raster along each axis.
constexpr std::size_t kNodes = 81;
/// Where the poses lie on the diagonals, from the corners.
constexpr double kDiagonalShare = 0.1;
/// So many times the wanted targets are tried before the workspace counts as too narrow.
constexpr std::size_t kMostTries = 200;

double radical_inverse(std::size_t index, std::size_t base) {
  double value = 0.0, digit = 1.0;
  for (; index > 0; index /= base) {
    digit /= static_cast<double>(base);
    value += digit * static_cast<double>(index % base);
  }
  return value;
}

Eigen::Vector2d place_in_ring(const Workspace& workspace, std::size_t index) {
  const double least = workspace.radius_min_m * workspace.radius_min_m;
  const double most = workspace.radius_max_m * workspace.radius_max_m;
  const double radius = std::sqrt(least + (most - least) * radical_inverse(index, 2));
  const double angle = 2.0 * kPi * radical_inverse(index, 3);
  return radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

/// Returns whether a cell can position its end point here.
bool is_usable(const CalibratedCell& cell, const Eigen::Vector2d& p) {
  const CellSettings& settings = cell.settings;
  const TipPose tip{p, settings.tool_orientation};
  return !settings.workspace.violation(p) && !cell.planner.plan(tip, settings.arm.home).refusal &&
         expect_tool(*cell.vision, tip) && predict_error_at(*cell.vision, tip).inside;
}

struct Raster {
  double first{0.0}, spacing{0.0};
  double usable{0.0};
  std::vector<std::vector<bool>> free;  ///< by row (y), then column (x)

  Eigen::Vector2d node(std::size_t column, std::size_t row) const {
    return {first + spacing * static_cast<double>(column),
            first + spacing * static_cast<double>(row)};
  }
};

Raster raster_of(const CalibratedCell& cell) {
  const Workspace& workspace = cell.settings.workspace;
  const double reach = workspace.radius_max_m;
  Raster raster{-reach, 2.0 * reach / static_cast<double>(kNodes - 1), 0.0, {}};
  std::size_t allowed = 0, free = 0;
  for (std::size_t row = 0; row < kNodes; ++row) {
    std::vector<bool>& nodes = raster.free.emplace_back();
    for (std::size_t column = 0; column < kNodes; ++column) {
      const Eigen::Vector2d p = raster.node(column, row);
      nodes.push_back(is_usable(cell, p));
      if (!workspace.violation(p)) ++allowed;
      if (nodes.back()) ++free;
    }
  }
  raster.usable =
      static_cast<double>(free) / static_cast<double>(std::max<std::size_t>(allowed, 1));
  return raster;
}

TestSquare square_at(const Raster& raster, const RasterSquare& found) {
  const double side = raster.spacing * static_cast<double>(found.side);
  return {raster.node(found.column, found.row) - Eigen::Vector2d::Constant(0.5 * side), side};
}

bool is_refused(DryRun& dry, const Eigen::Vector2d& p) {
  return dry.first_move({"", p, {}}).plan.refusal.has_value();
}

/// Plans two cycles of all moves, the way back to the first included, and leaves `dry` at their
/// end. Returns whether all ways are free.
bool can_cycle(DryRun& dry, const TestPlaces& places) {
  for (const CertificateMove& move : certificate_moves(places, 2))
    if ((move.p_before && is_refused(dry, *move.p_before)) || is_refused(dry, move.p_d))
      return false;
  return true;
}

/// Returns the places among `usable`, in the order of their angle about the base, to which the ways
/// are free.
std::vector<Eigen::Vector2d> free_tour(DryRun dry, std::vector<Eigen::Vector2d> usable) {
  std::sort(usable.begin(), usable.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return std::atan2(a.y(), a.x()) < std::atan2(b.y(), b.x());
  });
  const auto refused = [&](const Eigen::Vector2d& p) { return is_refused(dry, p); };
  usable.erase(std::remove_if(usable.begin(), usable.end(), refused), usable.end());
  return usable;
}

/// The tour goes once round the base, so that no motor winds itself up to its limits.
std::vector<Eigen::Vector2d> spread_targets(const CalibratedCell& cell, const DryRun& start,
                                            std::size_t wanted) {
  std::vector<Eigen::Vector2d> places, tour;
  for (std::size_t index = 1; index <= kMostTries * wanted; ++index) {
    const Eigen::Vector2d p = place_in_ring(cell.settings.workspace, index);
    if (!is_usable(cell, p)) continue;
    places.push_back(p);
    if (places.size() < wanted) continue;
    tour = free_tour(start, places);
    if (tour.size() < wanted) continue;
    tour.resize(wanted);  // one place more may open the way to several
    return tour;
  }
  throw InputError({fmt::format("{} of {} targets were found that arm, camera and error map reach",
                                tour.size(), wanted),
                    "record training positions over more of the workspace, or narrow the workspace "
                    "in the cell file",
                    cell.settings.file, Cause::kUnreachable});
}

namespace fs = std::filesystem;

fs::path cycles_file(const CertificateRequest& request) {
  return request.servo.folder.path / "cycles.csv";
}

/// Returns the settings that decide the moves, as comment lines. The calibration's files are those
/// of results.csv.
std::string header_of(const CertificateRequest& request, JudgeKind judge) {
  return cycles_header(
      {fmt::format("# cycles: {}", request.size.cycles),
       fmt::format("# targets: {}", request.size.targets),
       fmt::format("# judge: {}", name_in(kJudgeKinds, judge)),
       fmt::format("# cell: {}", content_sha256(request.servo.cell->settings.file))});
}

/// Returns the moves that the folder holds. Throws InputError when they are of another certificate.
std::vector<JudgedMove> moves_so_far(const CertificateRequest& request, const std::string& header) {
  const fs::path file = cycles_file(request), results = request.servo.folder.path / "results.csv";
  if (!fs::exists(file)) {
    if (fs::exists(results) && !read_results(results).empty())
      throw InputError(
          {"belongs to no certificate", "name another folder", results, Cause::kForeign});
    return {};
  }
  drop_torn_line(file, header);
  const std::string text = read_file(file);
  if (text.compare(0, header.size(), header) == 0) {
    ServoRequest servo = request.servo;
    servo.folder.resume = true;
    results_so_far(servo);  // throws where the moves were made with other calibration files
    return read_cycles(file);
  }
  throw InputError(
      {"was begun with other --cycles or --targets, with another judge or before the cell file was "
       "changed; its first lines say with which",
       "give the same ones to continue, or name another folder", file, Cause::kForeign});
}

/// Returns the objections to the cell's files. Throws InputError unless they are accepted.
std::vector<std::string> accepted_words(const CertificateRequest& request) {
  const CalibratedCell& cell = *request.servo.cell;
  if (!request.servo.accepted.stale) require_belonging(cell.stale);
  std::vector<std::string> words;  // the run warns of them
  for (const StaleFile& file : cell.stale) words.push_back(file.text());
  if (const auto map = accept_map(cell, request.servo.accepted.map))
    words.push_back(cell.settings.error_map.string() + ": " + *map);
  return words;
}

/// Drives a cell through the moves of its certificate.
class CertificateDriver {
 public:
  CertificateDriver(const CertificateRequest& request, CellDevices& devices)
      : phi_d_(request.servo.cell->settings.tool_orientation),
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
    made.sigma_vision = last_->measurement.noise_m;
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
  request.servo.folder.resume = fs::exists(request.servo.folder.path / "results.csv");
  CertificateDriver driver(request, devices);
  const std::size_t all = certificate.moves.size() + moves.size();
  if (progress) progress(certificate.moves.size(), all);
  const CalibratedCell& cell = *request.servo.cell;
  const auto judge = make_judge(certificate.judge, cell.settings, cell.vision->tool, devices,
                                request.servo.folder.path / "tracker.csv", request.servo.stop);
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

std::string pose_name(std::size_t index) {
  return fmt::format("P{}", index + 1);
}

std::vector<CertificateMove> certificate_moves(const TestPlaces& places, int cycles) {
  std::vector<CertificateMove> moves;
  const std::size_t poses = places.poses.size();
  for (int cycle = 1; cycle <= cycles; ++cycle)
    for (std::size_t i = 0; i < poses; ++i)
      moves.push_back({fmt::format("c{:02}.{}", cycle, pose_name(i)), CertificatePart::kPose,
                       pose_name(i), "", cycle, places.poses[i],
                       places.poses[(i + poses - 1) % poses]});
  const double way = 0.05 * places.square.side;  // by which a pose is approached
  for (int cycle = 1; cycle <= cycles; ++cycle)
    for (const std::size_t i : kVariationPoses)
      for (const ApproachSide& side : kSides)
        moves.push_back({fmt::format("v{:02}.{}{}", cycle, pose_name(i), side.name),
                         CertificatePart::kDirection, pose_name(i), side.name, cycle,
                         places.poses[i],
                         Eigen::Vector2d(places.poses[i] + way * Eigen::Vector2d(side.x, side.y))});
  for (std::size_t i = 0; i < places.targets.size(); ++i)
    moves.push_back({fmt::format("w{:03}", i + 1),
                     CertificatePart::kWorkspace,
                     "",
                     "",
                     0,
                     places.targets[i],
                     {}});
  return moves;
}

std::array<Eigen::Vector2d, 5> square_poses(const TestSquare& square) {
  const double half = (0.5 - kDiagonalShare) * square.side;
  const auto at = [&](double x, double y) {
    return Eigen::Vector2d(square.centre + half * Eigen::Vector2d(x, y));
  };
  return {square.centre, at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)};
}

std::vector<RasterSquare> free_squares(const std::vector<std::vector<bool>>& free) {
  std::vector<RasterSquare> squares;
  std::vector<std::vector<std::size_t>> nodes;  // along the side of the largest that ends there
  for (std::size_t row = 0; row < free.size(); ++row) {
    nodes.emplace_back(free[row].size(), 0);
    for (std::size_t column = 0; column < free[row].size(); ++column) {
      if (!free[row][column]) continue;
      std::size_t before = 0;
      if (row > 0 && column > 0)
        before =
            std::min({nodes[row - 1][column], nodes[row][column - 1], nodes[row - 1][column - 1]});
      nodes[row][column] = before + 1;
      if (before > 0) squares.push_back({column, row, before});
    }
  }
  std::stable_sort(squares.begin(), squares.end(),
                   [](const RasterSquare& a, const RasterSquare& b) { return a.side > b.side; });
  return squares;
}

TestPlaces find_test_places(const CalibratedCell& cell, std::size_t targets) {
  const Raster raster = raster_of(cell);
  const DryRun checked(cell, foresee_check(cell).end);
  for (const RasterSquare& found : free_squares(raster.free)) {
    const TestSquare square = square_at(raster, found);
    TestPlaces places{square, raster.spacing, raster.usable, square_poses(square), {}};
    DryRun dry = checked;
    if (!can_cycle(dry, places)) continue;
    places.targets = spread_targets(cell, dry, targets);
    return places;
  }
  throw InputError({"no square of the workspace is reached by arm, camera and error map",
                    "look at the limits and the workspace in the cell file with planar-doctor",
                    cell.settings.file, Cause::kUnreachable});
}

CertificateRun run_certificate(
    const CertificateRequest& request, const OpenDevices& open,
    const std::function<void(std::size_t done, std::size_t all)>& progress) {
  const CalibratedCell& cell = *request.servo.cell;
  require_calibrated(cell);
  CertificateRun certificate{request};
  certificate.judge = judge_of(cell.settings, cell.vision->tool);
  const std::string header = header_of(request, certificate.judge);
  certificate.moves = moves_so_far(request, header);
  certificate.accepted = accepted_words(request);
  certificate.places = find_test_places(cell, static_cast<std::size_t>(request.size.targets));
  const std::vector<CertificateMove> left = moves_left(certificate);
  if (left.empty()) return certificate;
  const auto devices = open(cell.settings);
  make_moves(certificate, left, header, *devices, progress);
  certificate.moves = read_cycles(cycles_file(request));  // to its digits, as when it is read again
  return certificate;
}

}  // namespace planar
