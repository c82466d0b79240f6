#include "planar_servo/offline/plan/proposed_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/each.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/learn/field/lamp_field.h"
#include "planar_servo/offline/map/learn_lamp_field.h"
#include "planar_servo/offline/plan/experiment_plan.h"
#include "planar_servo/offline/plan/predicted_positioning.h"

namespace planar {
namespace {

/// What is known of all unknowns, and what a reading adds.
class Knowledge {
 public:
  Knowledge(const JointEstimate& estimate, const std::vector<PoseSample>& candidates)
      : estimate_(estimate), covariance_(estimate.fit.covariance) {
    const LampField field = lamp_field(estimate, candidates);
    const std::vector<Eigen::Index> unknowns = field_unknowns(estimate);
    for (const PoseSample& candidate : candidates) {
      Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2, covariance_.rows());
      rows(Eigen::all, unknowns) = end_point_rows(field, candidate.lamps_B);
      end_points_.push_back(std::move(rows));
    }
  }

  /// Returns the standard deviation per axis of the end point at every candidate.
  std::vector<double> sigmas() const {
    std::vector<double> all;
    for (const Eigen::MatrixXd& rows : end_points_)
      all.push_back(std::sqrt(0.5 * (rows * covariance_).cwiseProduct(rows).sum()));
    return all;
  }

  /// Conditions on a reading of this pose.
  void add(const PoseSample& pose) {
    const JointFit& fit = estimate_.fit;
    const Eigen::Index n = fit.field_terms();
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(6, covariance_.rows());
    A.rightCols(estimate_.model().terms()) = estimate_.model().jacobian(pose, fit.arm);
    for (int lamp = 0; lamp < 2; ++lamp) {
      const Eigen::RowVectorXd b = fit.basis.at(pose.lamps_B[static_cast<std::size_t>(lamp)]);
      A.row(2 + 2 * lamp).head(b.size()) = b;
      A.row(3 + 2 * lamp).segment(n, b.size()) = b;
    }
    Eigen::MatrixXd S = A * covariance_ * A.transpose();
    S.diagonal().head<2>().array() += pose.sigma_reflector * pose.sigma_reflector;
    S.diagonal().tail<4>().array() += pose.sigma_lamp * pose.sigma_lamp;
    if (const auto gain = solve_positive(S, A * covariance_))
      covariance_ -= (A * covariance_).transpose() * *gain;
  }

 private:
  const JointEstimate& estimate_;
  Eigen::MatrixXd covariance_;
  std::vector<Eigen::MatrixXd> end_points_;
};

constexpr int kCandidates = 300;
constexpr std::uint64_t kOrderSeed = 1;
/// Noise of a lamp's place before one was measured, metres.
constexpr double kLampSigma_m = 2e-6;
/// Readings that bring the accuracy within this share of what all bring are enough.
constexpr double kNearly = 1.05;

/// Places where a reading could be taken.
struct Candidates {
  std::vector<PoseSample> poses;
  std::vector<TipPose> tips;  ///< as many
};

/// The cell as far as its files tell.
struct KnownCell {
  const CellSettings& cell;
  JointPlanner planner;
  ArmNominal nominal;
  std::optional<VisionCalibration> vision;
  double sigma_reading{0.0};  ///< of a planned one: as those before have it, or at the tracker
};

KnownCell known(const CellSettings& cell, const std::vector<PairRow>& pairs) {
  KnownCell known{
      cell, joint_planner(cell), {}, std::nullopt, median_of(pairs, &PairRow::sigma_tracker)};
  if (!(known.sigma_reading > 0.0)) known.sigma_reading = cell.tracker.sigma_m;
  if (missing_files(calibration_files(cell, false)).empty()) {
    known.vision = read_vision(cell, false);
    known.nominal = nominal_arm(cell, *known.vision);
  } else {
    known.nominal =
        nominal_arm(cell, VisionCalibration{cell.lamps.layout, {{}, Pose::Identity()}, {}});
    known.nominal.p_camera_B = ArmNominal().p_camera_B;
  }
  return known;
}

bool is_seen(const KnownCell& known, const TipPose& tip) {
  return !known.vision || lamps_from_tip(known.vision->workplane, known.vision->tool,
                                         known.cell.lamps.layout.separation_m, tip);
}

/// Returns what will be seen and read at these joint angles.
PoseSample pose_at(const KnownCell& known, const Joints& theta) {
  const ArmModel model(known.nominal, {0, true});
  PoseSample pose;
  pose.motors = known.planner.transmission().motors_from_joints(theta);
  const ToolPoints points = model.at({pose.motors, 0.0}, model.nominal());
  pose.lamps_B = {points.points.col(1), points.points.col(2)};
  pose.sigma_lamp = kLampSigma_m;
  pose.sigma_reflector = known.sigma_reading;
  return pose;
}

/// Returns places that fill the workspace evenly, as far as arm and camera reach.
Candidates candidates_of(const KnownCell& known) {
  const Eigen::Matrix2Xd places = spiral_over_disc(known.cell.workspace.radius_max_m, kCandidates);
  Candidates candidates;
  for (Eigen::Index i = 0; i < places.cols(); ++i) {
    const TipPose tip{places.col(i), known.cell.tool_orientation};
    const JointPlan plan = known.planner.plan(tip, known.cell.arm.home);
    if (plan.refusal || !is_seen(known, tip)) continue;
    candidates.poses.push_back(pose_at(known, plan.theta));
    candidates.tips.push_back(tip);
  }
  if (candidates.tips.empty())
    throw InputError({"no place of the workspace can be reached and seen",
                      "see planar-servo --dry-run for the reason", known.cell.file,
                      Cause::kUnreachable});
  return candidates;
}

/// Returns what is known before or after readings: by the pairs, or by the first rows of a plan.
JointEstimate estimate_of(const KnownCell& known, const std::vector<PairRow>& pairs) {
  JointEstimate estimate;
  estimate.nominal = known.nominal;
  if (!pairs.empty()) {
    const std::vector<PoseSample> samples = pose_samples(known.cell, pairs);
    spread_registration(estimate.nominal, known.cell, samples);
    return estimate_jointly(estimate.nominal, samples);
  }
  auto fit = fit_jointly(estimate.model(), {}, {}, known.cell.workspace.radius_max_m);
  if (!fit)
    throw WorkError("the equations of field and arm cannot be solved for this cell",
                    Cause::kInsufficient);
  estimate.fit = std::move(*fit);
  return estimate;
}

/// Mixes places in the same way on every platform.
void mix(std::vector<TipPose>& tips) {
  std::mt19937_64 rng(kOrderSeed);
  for (std::size_t left = tips.size(); left > 1; --left)
    std::swap(tips[left - 1], tips[rng() % left]);
}

/// Returns the joint angles at the place of a row if the arm may go there from others.
std::optional<Joints> way_to(const KnownCell& known, const Joints& from, const PlanRow& row) {
  const auto* theta = std::get_if<Joints>(&row.where);
  const JointPlan plan = theta ? JointPlan{*theta, known.planner.refusal(*theta)}
                               : known.planner.plan(std::get<TipPose>(row.where), from);
  if (plan.refusal || known.planner.way_refusal(from, plan.theta)) return std::nullopt;
  return plan.theta;
}

/// Leaves out the rows to which the arm may not go from where those before leave it, first at home.
/// Returns the joint angles at the others but the views of the board.
std::vector<Joints> keep_reachable(const KnownCell& known, std::vector<PlanRow>& rows) {
  std::vector<Joints> thetas;
  const auto is_barred = [&](const PlanRow& row) {
    if (shows_board(row.plan)) return false;
    const auto theta = way_to(known, thetas.empty() ? known.cell.arm.home : thetas.back(), row);
    if (theta) thetas.push_back(*theta);
    return !theta;
  };
  rows.erase(std::remove_if(rows.begin(), rows.end(), is_barred), rows.end());
  return thetas;
}

/// Turns the place at which joint 3 sweeps about the base to where the arm can make most of it.
std::vector<PlanRow> with_free_sweep(const KnownCell& known, const std::vector<PlanRow>& rows) {
  std::vector<PlanRow> most;
  for (int turn_deg = 0; turn_deg < 360 && most.size() < rows.size(); turn_deg += 30) {
    std::vector<PlanRow> turned = rows;
    for (PlanRow& row : turned)
      if (auto* tip = std::get_if<TipPose>(&row.where); tip && row.plan == Purpose::kSweep3)
        tip->p = rotation2d(turn_deg * kDegree) * tip->p;
    keep_reachable(known, turned);
    if (turned.size() > most.size()) most = std::move(turned);
  }
  return most;
}

/// Orders places at random, because a step in time can be told from the field only where successive
/// places are not neighbours. The arm stands at `at`, and then at the last. A place to which the
/// way is forbidden is tried again after the next one; those to which none leads are left out.
std::vector<PlanRow> rows_at_random(const KnownCell& known, Purpose plan, std::vector<TipPose> tips,
                                    std::size_t first, Joints& at) {
  mix(tips);
  std::vector<PlanRow> rows;
  for (std::size_t i = 0; i < tips.size();) {
    const PlanRow row{fmt::format("{}_{:03}", name_in(kPurposes, plan), first + rows.size()), plan,
                      tips[i]};
    const auto theta = way_to(known, at, row);
    if (!theta) {
      ++i;
      continue;
    }
    at = *theta;
    rows.push_back(row);
    tips.erase(tips.begin() + static_cast<std::ptrdiff_t>(i));
    i = 0;
  }
  return rows;
}

/// Returns a number beyond those of ids train_NNN or pose_NNN of the plans before: places that were
/// rejected had numbers, too, and have no pairs.
std::size_t next_number(Purpose plan, const std::vector<PairRow>& pairs) {
  constexpr std::size_t kRound = 100;
  const std::string prefix = fmt::format("{}_", name_in(kPurposes, plan));
  std::size_t next = pairs.size();
  for (const PairRow& pair : pairs) {
    std::size_t number = 0;
    if (pair.id.rfind(prefix, 0) != 0) continue;
    std::from_chars(pair.id.data() + prefix.size(), pair.id.data() + pair.id.size(), number);
    next = std::max(next, number + 1);
  }
  return (next + kRound - 1) / kRound * kRound;
}

/// Returns views of the board, sweeps and unattended poses of an experiment of this size.
std::vector<PlanRow> drawn_rows(const CellSettings& cell, ExperimentSize size,
                                std::uint64_t seed = 0) {
  size.training_points = size.test_points = size.check_points = size.run_points = 0;
  return experiment_plan(cell, seed, size).rows;
}

std::vector<TipPose> unattended_poses(const CellSettings& cell, int count, std::uint64_t seed) {
  ExperimentSize size;
  size.board_views = size.lays = size.sweep_points = 0;
  size.unattended_poses = count;
  return each(drawn_rows(cell, size, seed),
              [](const PlanRow& row) { return std::get<TipPose>(row.where); });
}

/// Throws InputError for fewer places than a plan without readings needs.
void require_poses(const CellSettings& cell, std::size_t n, std::size_t fewest) {
  if (n < fewest)
    throw InputError({fmt::format("the plan has no reading, and the arm can reach {} of its "
                                  "unattended poses",
                                  n),
                      fmt::format("{} are needed: plan more, or see planar-servo --dry-run for why "
                                  "places cannot be reached",
                                  fewest),
                      cell.file, Cause::kUnreachable});
}

/// Returns what a plan begins with that begins a calibration.
ExperimentSize first_size(const PlanRequest& request) {
  ExperimentSize size;
  size.lays = request.lays;
  if (request.readings > 0) return with_readings(size, request.readings);
  const auto fewest = static_cast<int>(kFewestPoses);
  if (request.lays < kFewestLays || request.unattended < fewest)
    throw InputError(
        {fmt::format("without a tracker reading {} lays of the board and {} unattended "
                     "poses do not tell the vision error",
                     request.lays, request.unattended),
         fmt::format("plan {} lays and {} poses at least", kFewestLays, fewest), "",
         Cause::kInsufficient});
  size.sweep_points = size.training_points = 0;
  return size;
}

double length_of(double sigma) {
  return sigma * std::sqrt(kPi / 2.0);
}

/// Chooses places for readings, and says in `plan` what to expect. The arm is read at `swept`
/// before.
std::vector<TipPose> most_telling(const KnownCell& known, const std::vector<PairRow>& pairs,
                                  int places, const std::vector<Joints>& swept,
                                  ProposedPlan& plan) {
  const Candidates candidates = candidates_of(known);
  const auto first = each(swept, [&](const Joints& theta) { return pose_at(known, theta); });
  const NextPlaces next = choose_next_places(estimate_of(known, pairs), candidates.poses,
                                             static_cast<std::size_t>(places), first);
  plan.before = length_of(next.sigmas.front());
  plan.after = length_of(next.sigmas.back());
  plan.enough = static_cast<int>(
      std::find_if(next.sigmas.begin(), next.sigmas.end(),
                   [&](double sigma) { return sigma <= kNearly * next.sigmas.back(); }) -
      next.sigmas.begin());
  return each(next.chosen, [&](std::size_t i) { return candidates.tips[i]; });
}

}  // namespace

NextPlaces choose_next_places(const JointEstimate& estimate,
                              const std::vector<PoseSample>& candidates, std::size_t count,
                              const std::vector<PoseSample>& first) {
  NextPlaces next;
  Knowledge knowledge(estimate, candidates);
  for (const PoseSample& pose : first) knowledge.add(pose);
  std::vector<double> sigmas = knowledge.sigmas();
  next.sigmas.push_back(mean(sigmas));
  std::vector<bool> taken(candidates.size(), false);
  while (next.chosen.size() < std::min(count, candidates.size())) {
    std::size_t best = candidates.size();
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (!taken[i] && (best == candidates.size() || sigmas[i] > sigmas[best])) best = i;
    taken[best] = true;
    next.chosen.push_back(best);
    knowledge.add(candidates[best]);
    sigmas = knowledge.sigmas();
    next.sigmas.push_back(mean(sigmas));
  }
  return next;
}

bool ProposedPlan::worth_reading() const {
  return before > kNearly * after;
}

ProposedPlan propose_plan(const CellSettings& cell, const PlanRequest& request,
                          const std::vector<PairRow>& pairs) {
  const KnownCell known_cell = known(cell, pairs);
  ProposedPlan plan;
  plan.readings = request.readings;
  int places = request.readings;
  if (pairs.empty()) {
    const ExperimentSize size = first_size(request);
    plan.rows = with_free_sweep(known_cell, drawn_rows(cell, size));
    places = size.training_points;
  }
  const std::vector<Joints> swept = keep_reachable(known_cell, plan.rows);
  Joints at = swept.empty() ? cell.arm.home : swept.back();
  const auto add = [&](Purpose kind, std::vector<TipPose> tips) {
    for (PlanRow& row :
         rows_at_random(known_cell, kind, std::move(tips), next_number(kind, pairs), at))
      plan.rows.push_back(std::move(row));
  };
  if (places > 0) add(Purpose::kTrain, most_telling(known_cell, pairs, places, swept, plan));
  const std::size_t before = plan.rows.size();
  add(Purpose::kPose, unattended_poses(cell, request.unattended, pairs.size()));
  if (request.readings == 0)
    require_poses(cell, plan.rows.size() - before, pairs.empty() ? kFewestPoses : 1);
  // Views of the board come last: only the other rows need the tracker, which is rented.
  const auto views =
      std::stable_partition(plan.rows.begin(), plan.rows.end(),
                            [](const PlanRow& row) { return !shows_board(row.plan); });
  plan.left_out =
      request.readings + request.unattended - static_cast<int>(views - plan.rows.begin());
  return plan;
}

ReportList proposal_list(const ProposedPlan& plan) {
  ReportList list;
  list.line("rows", "{rows}", plan.rows.size());
  list.line_if(plan.left_out > 0, "left out",
               "{left_out} of the places asked for: no further free one is known", plan.left_out);
  if (plan.readings == 0) return list;
  list.line("end point",
            "{expected_before_mm:.4f} mm expected now, {expected_after_mm:.4f} mm after these "
            "readings",
            plan.before, plan.after);
  list.line_if(!plan.worth_reading(), "stop", "further readings gain less than 5 %");
  list.line_if(plan.worth_reading(), "nearly there", "after {enough} places for training",
               plan.enough);
  list.unprinted("worth_reading", plan.worth_reading());
  return list;
}

}  // namespace planar
