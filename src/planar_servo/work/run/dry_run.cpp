#include "planar_servo/work/run/dry_run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/text.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/panel.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/report/report_list.h"

namespace planar {

namespace {

/// Places that are tried for the first moves when the arm must not make them where it stands.
constexpr int kRingPlaces = 24;
constexpr char kCheck[] = "the check of the cell";
constexpr char kWayOn[] =
    "correct `arm` and `workspace` in the cell file, keep other places by planar-pair-tracker "
    "--health-out, or move without the check (--no-health)";

/// Coordinates up to this are those of an arm of a metre, written in metres.
constexpr double kNearAxes_m = 1.0 * kMillimetre;
/// A full turn in radians is a little less.
constexpr double kRadiansOfTurn = 6.3;

/// `reach` says what reaches how far.
std::optional<Refusal> doubt_of_places(const std::vector<TargetRow>& targets,
                                       const std::string& reach, double reach_m) {
  double farthest_m = 0.0;
  for (const TargetRow& target : targets)
    farthest_m = std::max(farthest_m, target.p_d.cwiseAbs().maxCoeff());
  if (targets.empty() || farthest_m >= kNearAxes_m || reach_m <= kNearAxes_m) return std::nullopt;
  return Refusal{fmt::format("no coordinate is larger than {:g} mm, while {} to {:g} mm; metres "
                             "would be such numbers",
                             mm(farthest_m), reach, mm(reach_m)),
                 "write millimetres, such as 200 for 0.2 m", "", Cause::kContradiction};
}

std::optional<Refusal> doubt_of_directions(const std::vector<TargetRow>& targets) {
  constexpr double kWrittenDigit = 1e-6;
  double largest = 0.0;
  bool any_broken = false;
  for (const TargetRow& target : targets) {
    const double number = target.phi_d.value_or(0.0) / kDegree;
    if (std::abs(number) >= kRadiansOfTurn) return std::nullopt;
    largest = std::max(largest, std::abs(number));
    any_broken = any_broken || std::abs(number - std::round(number)) >= kWrittenDigit;
  }
  if (!any_broken) return std::nullopt;
  return Refusal{fmt::format("phi_deg is at most {:g} in every row; radians would be such numbers, "
                             "while degrees are read",
                             largest),
                 "write degrees, such as 90 for 1.571 radians, or leave it if it is meant so", "",
                 Cause::kContradiction};
}

std::optional<Refusal> doubt_of_places(const std::vector<TargetRow>& targets,
                                       const Workspace& workspace) {
  return doubt_of_places(targets, "the workspace reaches", workspace.radius_max_m);
}

using Points = std::vector<Eigen::Vector2d>;

constexpr const char* kBarred = kSeriesColors[1];

constexpr const char* kWay = "#999";
constexpr const char* kObstacle = "#333";

/// Draws lines as far as they lie within the axes; their points are close together.
void add_within(Panel& panel, const FieldAxes& axes, const Points& points_mm, Panel::Stroke stroke,
                const char* color) {
  Points run;
  const auto end_run = [&] {
    if (run.size() > 1) panel.add_line(run, stroke, color);
    run.clear();
  };
  for (const Eigen::Vector2d& p : points_mm) {
    if (p.x() >= axes.x.from && p.x() <= axes.x.to && p.y() >= axes.y.from && p.y() <= axes.y.to)
      run.push_back(p);
    else
      end_run();
  }
  end_run();
}

/// Returns the outline of a barrier in points that are close together.
Points outline_of(const Barrier& barrier) {
  if (barrier.corners_B.size() == 1) return circle_of(barrier.corners_B[0], barrier.radius_m);
  constexpr int kPieces = 20;
  Points outline;
  for (std::size_t i = 0; i < barrier.corners_B.size(); ++i) {
    const Eigen::Vector2d &a = barrier.corners_B[i],
                          &b = barrier.corners_B[(i + 1) % barrier.corners_B.size()];
    for (int k = 0; k <= kPieces; ++k) outline.emplace_back(a + (b - a) * k / kPieces);
  }
  return outline;
}

/// Returns a panel over these places, in it what the workspace forbids.
Panel panel_over(const std::string& title, const FieldAxes& axes, const Workspace& workspace) {
  Panel panel(title, axes);
  for (const Border& border : workspace.borders())
    if (border.radius_m > 0.0)
      add_within(panel, axes, in_mm(circle_of(border.p_B, border.radius_m)), Panel::Stroke::kDashed,
                 kBarred);
  for (const Barrier& barrier : workspace.barriers)
    add_within(panel, axes, in_mm(outline_of(barrier)), Panel::Stroke::kSolid, kObstacle);
  return panel;
}

/// Draws the same in the whole workspace, which has the legend, and by itself.
template <typename Draw, typename Explain>
std::string panels_html(const Points& places, const Workspace& workspace, const Draw& draw,
                        const Explain& explain) {
  const FieldAxes all = axes_over_places(in_mm(circle_of({0.0, 0.0}, workspace.radius_max_m)));
  const FieldAxes close = axes_over_places(in_mm(places));
  Panel whole = panel_over("In the workspace", all, workspace);
  Panel near = panel_over("By itself", close, workspace);
  draw(whole, all);
  draw(near, close);
  explain(whole);
  whole.add_key(kBarred, "borders and keep-out discs", Panel::Sample::kLine);
  if (!workspace.barriers.empty()) whole.add_key(kObstacle, "obstacles", Panel::Sample::kLine);
  return plot_html({whole, near});
}

HtmlPage page_about(const std::filesystem::path& file, const std::vector<std::string>& remarks) {
  HtmlPage page("What " + file.filename().string() + " would have the arm do");
  for (const std::string& remark : remarks) page.add_paragraph(remark + ".");
  return page;
}

}  // namespace

CheckWays::CheckWays(const CellSettings& cell, Views views)
    : cell_(cell), views_(std::move(views)), planner_(joint_planner(cell)) {}

bool CheckWays::allows(const Joints& from, const Joints& theta) const {
  return !approach_refusal(planner_, cell_.servo, from, theta) &&
         views_(planner_.arm().forward(theta));
}

std::optional<Joints> CheckWays::start(const Joints& present) const {
  if (allows(present, present)) return present;
  const double radius_m = 0.5 * (cell_.workspace.radius_min_m + cell_.workspace.radius_max_m);
  const Eigen::Vector2d p = planner_.arm().forward(present).p;
  const double direction = std::atan2(p.y(), p.x());
  for (int i = 0; i < kRingPlaces; ++i) {
    const int steps = (i + 1) / 2;
    const double turn = (i % 2 == 0 ? steps : -steps) * 2.0 * kPi / kRingPlaces;
    const JointPlan plan = planner_.plan(
        {radius_m * rotation2d(direction + turn).col(0), cell_.tool_orientation}, present);
    if (!plan.refusal && allows(present, plan.theta)) return plan.theta;
  }
  return std::nullopt;
}

Joints CheckWays::with_motor_turned(const Joints& theta, int motor) const {
  const Transmission& transmission = planner_.transmission();
  for (const double share : {1.0, -1.0, 0.5, -0.5, 0.25, -0.25}) {
    Eigen::Vector3d motors = transmission.motors_from_joints(theta);
    motors[motor] += share * first_moves()[motor];
    Joints turned = transmission.joints_from_motors(motors);
    if (allows(theta, turned)) return turned;
  }
  return theta;
}

VisitPlan CheckWays::visits(Joints theta, const std::vector<HealthPlace>& places) const {
  const Transmission& transmission = planner_.transmission();
  VisitPlan plan;
  std::vector<std::size_t> left(places.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  const auto bar = [&](std::size_t i) {
    return approach_refusal(planner_, cell_.servo, theta, places[i].theta);
  };
  const auto distance = [&](std::size_t i) {
    return (transmission.motors_from_joints(places[i].theta) -
            transmission.motors_from_joints(theta))
        .cwiseAbs()
        .maxCoeff();
  };
  while (!left.empty()) {
    std::sort(left.begin(), left.end(),
              [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
    const auto next =
        std::find_if(left.begin(), left.end(), [&](std::size_t i) { return !bar(i); });
    if (next == left.end()) break;
    plan.order.push_back(*next);
    theta = places[*next].theta;
    left.erase(next);
  }
  for (const std::size_t i : left)
    plan.barred.push_back(fmt::format("place '{}': {}", places[i].id, *bar(i)));
  return plan;
}

ForeseenCheck foresee_check(const CalibratedCell& cell) {
  require_faultless(cell);
  const auto& vision = cell.vision;
  const CheckWays ways(cell.settings, [&](const TipPose& tip) {
    return !vision ||
           lamps_from_tip(vision->workplane, vision->tool, vision->lamps.separation_m, tip);
  });
  const Joints& home = cell.settings.arm.home;
  const auto start = ways.start(home);
  if (!start)
    return {home,
            Refusal{"no place for the first moves lies in the workspace and the camera's view",
                    kWayOn, kCheck, Cause::kUnreachable},
            true};
  ForeseenCheck foreseen{*start};
  for (int motor = 0; motor < 3; ++motor)
    foreseen.end = ways.with_motor_turned(foreseen.end, motor);
  const auto& record = cell.health;
  if (!record) return foreseen;
  const VisitPlan visits = ways.visits(foreseen.end, record->places);
  if (!visits.order.empty()) foreseen.end = record->places[visits.order.back()].theta;
  foreseen.refused = visits.order.empty();
  if (!visits.barred.empty())
    foreseen.doubt = Refusal{barred_text(visits.barred, record->places.size()), kWayOn, kCheck,
                             Cause::kUnreachable};
  return foreseen;
}

std::string barred_text(const std::vector<std::string>& barred, std::size_t places) {
  return fmt::format("{} of the {} places of the health file cannot be visited again ({}){}",
                     barred.size(), places, fmt::join(barred, "; "),
                     barred.size() == places
                         ? ""
                         : "; with fewer than four, a place at which the arm strayed passes for a "
                           "change of the cell");
}

TipPose target_pose(const TargetRow& target, double tool_orientation) {
  return {target.p_d, target.phi_d.value_or(tool_orientation)};
}

TipPose end_point_pose(const TargetRow& target, double tool_orientation) {
  const TipPose tip = target_pose(target, tool_orientation);
  return {end_point_for(tip.p, tip.phi, target.p_TE), tip.phi};
}

DryRun::DryRun(const CalibratedCell& cell, const Joints& start)
    : tool_orientation_(cell.settings.tool_orientation),
      planner_(cell.planner),
      servo_(cell.settings.servo),
      near_(start) {
  require_arm(cell);
}

DryRunRow DryRun::first_move(const TargetRow& target) {
  DryRunRow row{target.id, planner_.plan(end_point_pose(target, tool_orientation_), near_),
                Pulses::Zero()};
  if (row.plan.refusal) return row;
  const ApproachWay way = approach_way(planner_, servo_, near_, row.plan.theta);
  row.plan.refusal = way.refusal;
  if (row.plan.refusal) return row;
  Joints from = near_;
  for (const Joints& stop : way.stops) {
    const auto drawn = planner_.drawn_way(from, stop);
    row.way_B.insert(row.way_B.end(), drawn.begin(), drawn.end());
    from = stop;
  }
  near_ = row.plan.theta = way.stops.back();
  row.pulses = planner_.transmission().pulses_from_joints(near_);
  return row;
}

void refuse_outside_map(std::vector<DryRunRow>& rows, const std::vector<TargetRow>& targets,
                        const CalibratedCell& cell) {
  const VisionCalibration& vision = cell.vision.value();
  if (!vision.error_map) return;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TipPose target = end_point_pose(targets[i], cell.settings.tool_orientation);
    if (rows[i].plan.refusal || predict_error_at(vision, target).inside) continue;
    rows[i].plan.refusal =
        "the error map is not valid here: record training positions around this target";
  }
}

std::vector<DryRunRow> first_moves_to(const CalibratedCell& cell, const Joints& start,
                                      const std::vector<TargetRow>& targets) {
  DryRun dry(cell, start);
  return each(targets, [&dry](const TargetRow& target) { return dry.first_move(target); });
}

std::vector<DryRunRow> refused_of(std::vector<DryRunRow> rows) {
  rows.erase(std::remove_if(rows.begin(), rows.end(),
                            [](const DryRunRow& row) { return !row.plan.refusal; }),
             rows.end());
  return rows;
}

std::string dry_run_text(const std::vector<DryRunRow>& rows) {
  std::string text;
  for (const DryRunRow& row : rows)
    text += row.id + (row.plan.refusal ? fmt::format(": refused: {}\n", *row.plan.refusal)
                                       : fmt::format(": joints {} deg, pulses {}\n",
                                                     fixed(row.plan.theta / kDegree, 4, " "),
                                                     fmt::join(row.pulses, " ")));
  return text;
}

nlohmann::ordered_json first_move_answer(const DryRunRow& row) {
  if (row.plan.refusal)
    return {{"target", row.id}, {"status", "refused"}, {"reason", *row.plan.refusal}};
  const Eigen::Vector3d deg = row.plan.theta / kDegree;
  return {{"target", row.id},
          {"status", "planned"},
          {"theta_deg", {deg[0], deg[1], deg[2]}},
          {"pulses", {row.pulses[0], row.pulses[1], row.pulses[2]}}};
}

nlohmann::json dry_run_json(const std::vector<DryRunRow>& rows) {
  nlohmann::json moves = nlohmann::json::array();
  for (const DryRunRow& row : rows) moves.push_back(nlohmann::json(first_move_answer(row)));
  return {{"moves", moves}};
}

std::optional<Refusal> doubt_on_work(const std::vector<TargetRow>& drawn, const FoundWork& work) {
  double reach_m = 0.0;
  for (const FoundFiducial& mark : work.fiducials)
    reach_m = std::max(reach_m, mark.fiducial.p_W.cwiseAbs().maxCoeff());
  return doubt_of_places(drawn, "the work's marks reach", reach_m);
}

std::vector<Refusal> target_doubts(const std::vector<TargetRow>& targets,
                                   const Workspace& workspace) {
  std::vector<Refusal> doubts;
  for (const auto& doubt : {doubt_of_places(targets, workspace), doubt_of_directions(targets)})
    if (doubt) doubts.push_back(*doubt);
  return doubts;
}

void question_targets(const std::vector<TargetRow>& targets, const Workspace& workspace,
                      const std::filesystem::path& file) {
  const bool any_allowed =
      std::any_of(targets.begin(), targets.end(),
                  [&](const TargetRow& target) { return !workspace.violation(target.p_d); });
  const auto places = doubt_of_places(targets, workspace);
  if (places && !any_allowed) throw InputError(places->at(file));
  for (const Refusal& doubt : target_doubts(targets, workspace))
    spdlog::warn(doubt.at(file).text());
}

std::string plan_page(const Workspace& workspace, const std::filesystem::path& file,
                      const Path& path, const std::vector<std::string>& remarks) {
  HtmlPage page = page_about(file, remarks);
  const Points places = drawn_places(path);
  page.add_html(panels_html(
      places, workspace,
      [&](Panel& panel, const FieldAxes& /*axes*/) {
        panel.add_line(in_mm(places), Panel::Stroke::kSolid, kSeriesColors[0]);
        panel.add_dots(in_mm({places.front()}), {kSeriesColors[2]}, 4.0);
      },
      [](Panel& panel) {
        panel.add_key(kSeriesColors[0], "the path", Panel::Sample::kLine);
        panel.add_key(kSeriesColors[2], "its beginning");
      }));
  page.add_paragraph(fmt::format("The path is {:.1f} mm long; places are in the base frame.",
                                 mm(path.length_m())));
  return page.text();
}

std::string plan_page(const Workspace& workspace, const std::filesystem::path& file,
                      const std::vector<TargetRow>& targets, const std::vector<DryRunRow>& rows,
                      const std::vector<std::string>& remarks) {
  HtmlPage page = page_about(file, remarks);
  Points all, refused, way;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    all.push_back(targets[i].p_d);
    if (rows.at(i).plan.refusal) refused.push_back(targets[i].p_d);
    way.insert(way.end(), rows[i].way_B.begin(), rows[i].way_B.end());
  }
  page.add_html(panels_html(
      all, workspace,
      [&](Panel& panel, const FieldAxes& axes) {
        add_within(panel, axes, in_mm(way), Panel::Stroke::kSolid, kWay);
        panel.add_dots(in_mm(all), {kSeriesColors[0]}, 3.0);
        panel.add_dots(in_mm(refused), {kSeriesColors[3]}, 4.0);
      },
      [&](Panel& panel) {
        panel.add_key(kSeriesColors[0], "targets");
        panel.add_key(kWay, "the end point's way to them", Panel::Sample::kLine);
        if (!refused.empty()) panel.add_key(kSeriesColors[3], "refused");
      }));
  ReportList list;
  for (std::size_t i = 0; i < targets.size(); ++i)
    list.row("targets", {{"target", targets[i].id},
                         {"x mm", fixed(mm(targets[i].p_d.x()), 3)},
                         {"y mm", fixed(mm(targets[i].p_d.y()), 3)},
                         {"refused because", rows[i].plan.refusal.value_or("")}});
  list.show("targets", "Targets");
  page.add_html("<div class=\"words\">" + list.table_html("targets") + "</div>");
  return page.text();
}

}  // namespace planar
