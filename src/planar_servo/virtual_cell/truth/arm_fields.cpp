#include "planar_servo/virtual_cell/truth/arm_fields.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/base/io/fields.h"

namespace planar {
namespace {

constexpr const char* kJoints[] = {"joint1", "joint2", "joint3"};

using Reducers = std::array<ReducerTruth, 3>;

void list_axis_leans(Fields& fields, ArmTruth& arm) {
  const Range lean = Range::from_to(-10.0, 10.0);
  const Eigen::Vector2d none(0.0, 0.0);
  list_optional(fields, "axis_leans_deg", arm.axis_leans_rad, {none, none, none},
                [&](std::array<Eigen::Vector2d, 3>& leans) {
                  fields.map("axis_leans_deg", [&] {
                    for (std::size_t i = 0; i < leans.size(); ++i)
                      fields.numbers(kJoints[i], leans[i], kDegree, lean);
                  });
                });
}

void list_each(Fields& fields, const char* key, Reducers& reducers, double ReducerTruth::*number,
               double unit, const Range& range) {
  fields.row(key, [&](RowFields& row) {
    for (ReducerTruth& reducer : reducers) row.number(reducer.*number, unit, range);
  });
}

/// Visits rows of harmonics of every reducer.
void list_each(Fields& fields, Reducers& reducers, std::vector<Harmonic> ReducerTruth::*harmonics,
               double unit) {
  for (std::size_t i = 0; i < reducers.size(); ++i)
    list_harmonics(fields, kJoints[i], reducers[i].*harmonics, unit);
}

template <typename Has>
bool any_reducer(const Reducers& reducers, const Has& has) {
  return std::any_of(reducers.begin(), reducers.end(), has);
}

void list_ripple(Fields& fields, Reducers& reducers) {
  const bool ripples =
      any_reducer(reducers, [](const ReducerTruth& reducer) { return !reducer.ripple.empty(); });
  if (!fields.given("ripple", ripples)) return;
  const Range share = Range::from_to(0.0, 0.9);
  fields.map("ripple", [&] {
    list_each(fields, reducers, &ReducerTruth::ripple, kDegree);
    list_each(fields, "modulation", reducers, &ReducerTruth::ripple_modulation, 1.0, share);
    list_each(fields, "skew", reducers, &ReducerTruth::ripple_skew, 1.0, share);
  });
}

/// Returns whether the shaft never turns back while its drive turns on.
bool turns_on(const std::vector<Harmonic>& microsteps) {
  double slope = 0.0;
  for (const Harmonic& h : microsteps) slope += std::abs(h.amplitude) * h.order;
  return slope < 1.0;
}

void list_microsteps(Fields& fields, Reducers& reducers) {
  const bool uneven = any_reducer(
      reducers, [](const ReducerTruth& reducer) { return !reducer.microsteps.empty(); });
  if (!fields.given("microsteps", uneven)) return;
  fields.map("microsteps", [&] {
    list_each(fields, reducers, &ReducerTruth::microsteps, kFullStep);
    for (std::size_t i = 0; i < reducers.size(); ++i)
      fields.check(turns_on(reducers[i].microsteps),
                   {"arm.microsteps must not turn the motor back between two microsteps"},
                   kJoints[i]);
  });
}

void list_hysteresis(Fields& fields, Reducers& reducers) {
  const bool winds = any_reducer(
      reducers, [](const ReducerTruth& reducer) { return reducer.hysteresis_rad > 0.0; });
  if (!fields.given("hysteresis", winds)) return;
  fields.map("hysteresis", [&] {
    list_each(fields, "half_width_deg", reducers, &ReducerTruth::hysteresis_rad, kDegree,
              Range::at_least(0.0));
    list_each(fields, "forgotten_after_deg", reducers, &ReducerTruth::forgetting_rad, kDegree,
              Range::positive());
  });
}

void list_axis_errors(Fields& fields, const std::string& key, const char* unit_name,
                      std::optional<AxisErrorTruth>& errors, double unit) {
  list_optional_block(fields, key, errors, [&](AxisErrorTruth& error) {
    fields.numbers(unit_name, error.sizes, unit, Range::at_least(0.0));
    fields.numbers("phases_deg", error.phases_rad, kDegree);
  });
}

void list_warming(Fields& fields, std::optional<ArmWarmingTruth>& warming) {
  list_optional_block(fields, "warming", warming, [&](ArmWarmingTruth& warm) {
    fields.number("growth_um_per_m", warm.growth, kMicrometre);
    fields.numbers("zero_shifts_deg", warm.zero_shifts_rad, kDegree);
    fields.number("motor_time_constant_h", warm.motor_time_s, kHour, Range::positive());
    fields.number("link_time_constant_h", warm.link_time_s, kHour, Range::positive());
    fields.number("holding_share", warm.holding_share, 1.0, Range::from_to(0.0, 1.0));
    fields.check(warm.motor_time_s != warm.link_time_s,
                 {"arm.warming must have two different time constants"}, "link_time_constant_h");
  });
}

void list_backlash_variation(Fields& fields, Reducers& reducers) {
  if (fields.given("backlash_variation", any_reducer(reducers, [](const ReducerTruth& reducer) {
                     return reducer.backlash_variation > 0.0;
                   })))
    list_each(fields, "backlash_variation", reducers, &ReducerTruth::backlash_variation, 1.0,
              Range::from_to(0.0, 1.0));
}

}  // namespace

void list_fields(Fields& fields, ArmTruth& arm) {
  fields.numbers("link_lengths_mm", arm.link_lengths_m, kMillimetre, Range::positive());
  list_each(fields, "zero_offsets_deg", arm.reducers, &ReducerTruth::zero_offset_rad, kDegree,
            Range::any());
  list_each(fields, "backlash_deg", arm.reducers, &ReducerTruth::backlash_rad, kDegree,
            Range::at_least(0.0));
  list_backlash_variation(fields, arm.reducers);
  fields.map("eccentricity",
             [&] { list_each(fields, arm.reducers, &ReducerTruth::eccentricity, kDegree); });
  list_optional_block(fields, "beam_sag", arm.beam_sag, [&](BeamSagTruth& sag) {
    fields.number("bending_mm_per_m2", sag.bending_m_per_m2, kMillimetre);
    fields.number("twisting_mm_per_m2", sag.twisting_m_per_m2, kMillimetre);
  });
  list_axis_leans(fields, arm);
  list_ripple(fields, arm.reducers);
  list_microsteps(fields, arm.reducers);
  list_hysteresis(fields, arm.reducers);
  list_axis_errors(fields, "runout", "um", arm.runout, kMicrometre);
  list_axis_errors(fields, "wobble", "arcsec", arm.wobble, kArcSecond);
  list_optional_block(fields, "scatter", arm.scatter, [&](ScatterTruth& stop) {
    fields.number("sigma_um", stop.sigma_m, kMicrometre, Range::at_least(0.0));
    fields.number("short_move_factor", stop.short_move_factor, 1.0, Range::at_least(0.0));
    fields.number("negative_factor", stop.negative_factor, 1.0, Range::at_least(0.0));
  });
  list_warming(fields, arm.warming);
  list_optional_block(fields, "height_wave", arm.height_wave, [&](HeightWaveTruth& rings) {
    fields.number("amplitude_um", rings.amplitude_m, kMicrometre);
    fields.numbers("center_mm", rings.center_m, kMillimetre);
  });
  list_optional_block(fields, "bending", arm.bending, [&](BendingTruth& bent) {
    fields.number("largest_um", bent.largest_m, kMicrometre, Range::at_least(0.0));
    fields.number("slack_deg", bent.slack_rad, kDegree);
  });
  list_optional_block(fields, "base_motion", arm.base_motion, [&](BaseMotionTruth& base) {
    fields.number("largest_um", base.largest_m, kMicrometre, Range::at_least(0.0));
    fields.number("period_min", base.period_s, 60.0, Range::positive());
    fields.number("direction_deg", base.direction_rad, kDegree);
  });
  list_optional_block(fields, "creep", arm.creep, [&](CreepTruth& tip) {
    fields.number("largest_um", tip.largest_m, kMicrometre, Range::at_least(0.0));
    fields.number("time_s", tip.time_s, 1.0, Range::positive());
  });
}

void list_harmonics(Fields& fields, const std::string& key, std::vector<Harmonic>& harmonics,
                    double unit) {
  constexpr int kMaxOrder = 1000;
  fields.rows(key, harmonics, [&](RowFields& row, Harmonic& harmonic) {
    row.number(harmonic.amplitude, unit);
    row.number(harmonic.phase_rad, kDegree);
    row.whole_number(harmonic.order, 0, kMaxOrder);
  });
}

}  // namespace planar
