#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/fields.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {
namespace {

constexpr Named<double> kSenses[] = {{1.0, "counterclockwise"}, {-1.0, "clockwise"}};
constexpr Named<bool> kRides[] = {{true, "relative"}, {false, "absolute"}};

/// Visits a key that a file may leave out; `list(Value&)` visits its value.
template <typename Value, typename List>
void list_optional(Fields& fields, const std::string& key, std::optional<Value>& field,
                   const Value& first, const List& list) {
  if (!fields.given(key, field.has_value())) return;
  Value value = field.value_or(first);
  list(value);
  field = value;
}

/// Visits a block of keys that a file may leave out; `list(Value&)` visits its keys.
template <typename Value, typename List>
void list_optional_block(Fields& fields, const std::string& key, std::optional<Value>& field,
                         const List& list) {
  list_optional(fields, key, field, Value(),
                [&](Value& value) { fields.map(key, [&] { list(value); }); });
}

/// Visits rows of [amplitude, phase_deg, order].
void list_harmonics(Fields& fields, const std::string& key, std::vector<Harmonic>& harmonics,
                    double unit) {
  constexpr int kMaxOrder = 1000;
  fields.rows(key, harmonics, [&](RowFields& row, Harmonic& harmonic) {
    row.number(harmonic.amplitude, unit);
    row.number(harmonic.phase_rad, kDegree);
    row.whole_number(harmonic.order, 0, kMaxOrder);
  });
}

/// Visits such rows that a file may leave out.
void list_given_harmonics(Fields& fields, const std::string& key, std::vector<Harmonic>& harmonics,
                          double unit) {
  if (fields.given(key, !harmonics.empty())) list_harmonics(fields, key, harmonics, unit);
}

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

bool any_has(const Reducers& reducers, std::vector<Harmonic> ReducerTruth::*harmonics) {
  return std::any_of(reducers.begin(), reducers.end(),
                     [&](const ReducerTruth& reducer) { return !(reducer.*harmonics).empty(); });
}

bool any_has(const Reducers& reducers, double ReducerTruth::*number) {
  return std::any_of(reducers.begin(), reducers.end(),
                     [&](const ReducerTruth& reducer) { return reducer.*number > 0.0; });
}

void list_ripple(Fields& fields, Reducers& reducers) {
  if (!fields.given("ripple", any_has(reducers, &ReducerTruth::ripple))) return;
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
  if (!fields.given("microsteps", any_has(reducers, &ReducerTruth::microsteps))) return;
  fields.map("microsteps", [&] {
    list_each(fields, reducers, &ReducerTruth::microsteps, kFullStep);
    for (std::size_t i = 0; i < reducers.size(); ++i)
      fields.check(turns_on(reducers[i].microsteps),
                   {"arm.microsteps must not turn the motor back between two microsteps"},
                   kJoints[i]);
  });
}

void list_hysteresis(Fields& fields, Reducers& reducers) {
  if (!fields.given("hysteresis", any_has(reducers, &ReducerTruth::hysteresis_rad))) return;
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

/// Lists the keys of the block `arm` that say what is wrong with the arm.
void list_fields(Fields& fields, ArmTruth& arm) {
  fields.numbers("link_lengths_mm", arm.link_lengths_m, kMillimetre, Range::positive());
  list_each(fields, "zero_offsets_deg", arm.reducers, &ReducerTruth::zero_offset_rad, kDegree,
            Range::any());
  list_each(fields, "backlash_deg", arm.reducers, &ReducerTruth::backlash_rad, kDegree,
            Range::at_least(0.0));
  if (fields.given("backlash_variation", any_has(arm.reducers, &ReducerTruth::backlash_variation)))
    list_each(fields, "backlash_variation", arm.reducers, &ReducerTruth::backlash_variation, 1.0,
              Range::from_to(0.0, 1.0));
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

/// Lists the keys of the block `arm` that may differ from what the cell file states.
void list_fields(Fields& fields, BuildTruth& build) {
  list_optional(fields, "positive_rotation", build.sense, 1.0,
                [&](double& sense) { fields.choice("positive_rotation", sense, kSenses); });
  list_optional(
      fields, "coupling", build.relative, {true, true},
      [&](std::array<bool, 2>& relative) { fields.choices("coupling", relative, kRides); });
  const Eigen::Vector3d ones = Eigen::Vector3d::Ones();
  list_optional(fields, "gear_ratios", build.gear_ratios, ones, [&](Eigen::Vector3d& ratios) {
    fields.numbers("gear_ratios", ratios, 1.0, Range::positive());
  });
  list_optional(fields, "directions", build.directions, ones, [&](Eigen::Vector3d& directions) {
    if (fields.numbers("directions", directions))
      fields.check((directions.array().abs() == 1.0).all(), {"arm.directions may be 1 and -1"},
                   "directions");
  });
  list_optional(fields, "home_deg", build.home_rad, ones,
                [&](Eigen::Vector3d& home) { fields.numbers("home_deg", home, kDegree); });
}

void list_monuments(Fields& fields, VirtualMonuments& monuments) {
  if (!fields.given("monuments", !monuments.empty())) return;
  fields.maps("monuments", monuments, [&](VirtualMonuments::value_type& monument) {
    fields.text("id", monument.first);
    fields.number("x_mm", monument.second.x(), kMillimetre);
    fields.number("y_mm", monument.second.y(), kMillimetre);
    fields.number("z_mm", monument.second.z(), kMillimetre);
  });
}

void list_outliers(Fields& fields, std::optional<OutlierTruth>& outliers) {
  list_optional_block(fields, "outliers", outliers, [&](OutlierTruth& stray) {
    fields.number("share", stray.share, 1.0, Range::from_to(0.0, 1.0));
    fields.number("from_mm", stray.from_m, kMillimetre, Range::positive());
    fields.number("to_mm", stray.to_m, kMillimetre, Range::positive());
    fields.check(stray.from_m <= stray.to_m, {"outliers.from_mm must not exceed outliers.to_mm"},
                 "from_mm");
  });
}

void list_fields(Fields& fields, CameraTruth& camera) {
  fields.map("X_CB", [&] { list_pose(fields, camera.X_CB); });
  fields.numbers("focal_px", camera.focal_px, 1.0, Range::positive());
  fields.numbers("center_px", camera.center_px);
  fields.map("lens", [&] {
    fields.numbers("radial", camera.radial);
    fields.numbers("decentring", camera.decentring);
  });
  fields.number("blur_px", camera.blur_px, 1.0, Range::from_to(0.1, 20.0));
  fields.rows("warp", camera.warp, [](RowFields& row, WarpBump& bump) {
    for (double& coordinate : bump.center_px) row.number(coordinate);
    row.number(bump.sigma_px, 1.0, Range::positive());
    for (double& coordinate : bump.amplitude_px) row.number(coordinate);
  });
  list_optional_block(fields, "air", camera.air, [&](AirTruth& moving) {
    fields.number("sigma_px", moving.sigma_px, 1.0, Range::at_least(0.0));
    fields.number("time_s", moving.time_s, 1.0, Range::positive());
    fields.number("length_px", moving.length_px, 1.0, Range::positive());
  });
}

void list_fields(Fields& fields, GlowTruth& glow) {
  fields.numbers("gradient_tool", glow.gradient_tool);
  fields.number("gradient_view", glow.gradient_view);
  fields.numbers("halo_tool", glow.halo_tool);
  fields.number("halo_view", glow.halo_view);
  fields.number("halo_decay_mm", glow.halo_decay_m, kMillimetre, Range::positive());
}

void list_fields(Fields& fields, LampTruth& lamp) {
  fields.number("diameter_mm", lamp.diameter_m, kMillimetre, Range::positive());
  fields.number("peak_level", lamp.peak_level, 1.0, Range::at_least(0.0));
  fields.map("glow", [&] { list_fields(fields, lamp.glow); });
  list_harmonics(fields, "rim_harmonics", lamp.rim, 1.0);
}

void list_reference_lamps(Fields& fields, std::vector<ReferenceLampTruth>& lamps) {
  if (!fields.given("reference_lamps", !lamps.empty())) return;
  fields.maps("reference_lamps", lamps, [&](ReferenceLampTruth& lamp) {
    fields.text("id", lamp.id);
    fields.number("x_mm", lamp.p_B.x(), kMillimetre);
    fields.number("y_mm", lamp.p_B.y(), kMillimetre);
    fields.number("z_mm", lamp.p_B.z(), kMillimetre);
    list_fields(fields, lamp.lamp);
  });
}

void list_drift(Fields& fields, CameraTruth& camera) {
  fields.numbers("px_per_h", camera.drift_px_per_h);
  list_optional_block(fields, "warming", camera.warming, [&](WarmingTruth& warming) {
    fields.numbers("shift_px", warming.shift_px);
    fields.number("turn_deg", warming.turn_rad, kDegree);
    fields.number("growth", warming.growth, 1.0, Range::from_to(-0.1, 0.1));
    fields.number("time_constant_h", warming.time_constant_s, kHour, Range::positive());
  });
}

void list_fields(Fields& fields, ToolTruth& tool) {
  fields.numbers("lamp1_mm", tool.lamps_m[0], kMillimetre);
  fields.numbers("lamp2_mm", tool.lamps_m[1], kMillimetre);
  fields.number("lamp_height_mm", tool.lamp_height_m, kMillimetre);
  fields.numbers("reflector_mm", tool.reflector_m, kMillimetre);
  if (!fields.given("tip_mm", tool.tip.has_value())) return;
  if (!tool.tip) tool.tip.emplace();
  fields.numbers("tip_mm", tool.tip->p_T, kMillimetre);
  fields.number("tip_diameter_mm", tool.tip->diameter_m, kMillimetre, Range::positive());
}

void list_fields(Fields& fields, TrackerTruth& tracker) {
  fields.map("X_LB", [&] { list_pose(fields, tracker.X_LB); });
  fields.number("sigma_mm", tracker.sigma_m, kMillimetre, Range::at_least(0.0));
  fields.number("bias_mm", tracker.bias_m, kMillimetre, Range::at_least(0.0));
  fields.number("bias_wavelength_mm", tracker.bias_wavelength_m, kMillimetre, Range::positive());
  list_optional(fields, "mispaired_share", tracker.mispaired_share, 0.0, [&](double& share) {
    fields.number("mispaired_share", share, 1.0, Range::from_to(0.0, 1.0));
  });
  list_given_harmonics(fields, "azimuth_errors_urad", tracker.azimuth_errors, kMicroradian);
  list_given_harmonics(fields, "elevation_errors_urad", tracker.elevation_errors, kMicroradian);
  list_optional_block(fields, "station_drift", tracker.drift, [&](StationDriftTruth& station) {
    fields.numbers("um_per_h", station.velocity_m_s, kMicrometre / kHour);
    fields.numbers("settling_um", station.settling_m, kMicrometre);
    fields.number("half_time_h", station.half_time_s, kHour, Range::positive());
  });
}

void list_fields(Fields& fields, NoiseTruth& noise) {
  fields.number("background_level", noise.background_level, 1.0, Range::at_least(0.0));
  fields.number("gain_e_per_level", noise.gain_e_per_level, 1.0, Range::positive());
  fields.number("read_noise_levels", noise.read_noise_levels, 1.0, Range::at_least(0.0));
}

void list_fields(Fields& fields, BoardTruth& board) {
  fields.whole_number("columns", board.columns, 2, 100);
  fields.whole_number("rows", board.rows, 2, 100);
  fields.number("pitch_mm", board.pitch_m, kMillimetre, Range::positive());
  fields.number("dot_diameter_mm", board.dot_diameter_m, kMillimetre, Range::positive());
  fields.number("bright_level", board.bright_level, 1.0, Range::at_least(0.0));
  fields.number("dark_level", board.dark_level, 1.0, Range::at_least(0.0));
}

void list_fields(Fields& fields, WorkMarkTruth& mark) {
  fields.choice("shape", mark.shape, kMarkShapes);
  fields.number("x_mm", mark.p_W.x(), kMillimetre);
  fields.number("y_mm", mark.p_W.y(), kMillimetre);
  fields.number("size_mm", mark.size_m, kMillimetre, Range::positive());
  if (fields.given("tag", mark.shape == MarkShape::kAprilTag))
    fields.whole_number("tag", mark.tag, 0, 586);
}

void list_fields(Fields& fields, WorkpieceTruth& work) {
  fields.numbers("p_BW_mm", work.p_BW, kMillimetre);
  fields.number("turn_deg", work.turn_rad, kDegree);
  fields.numbers("plate_from_mm", work.plate_from_m, kMillimetre);
  fields.numbers("plate_to_mm", work.plate_to_m, kMillimetre);
  fields.number("plate_level", work.plate_level, 1.0, Range::at_least(0.0));
  fields.number("bright_level", work.bright_level, 1.0, Range::at_least(0.0));
  fields.number("dark_level", work.dark_level, 1.0, Range::at_least(0.0));
  list_optional_block(fields, "slide", work.slide, [&](SlideTruth& slide) {
    fields.number("at_s", slide.at_s, 1.0, Range::at_least(0.0));
    fields.numbers("shift_mm", slide.shift_m, kMillimetre);
    fields.number("turn_deg", slide.turn_rad, kDegree);
  });
  fields.maps("marks", work.marks, [&](WorkMarkTruth& mark) { list_fields(fields, mark); });
}

void list_fields(Fields& fields, Truth& truth) {
  fields.map("arm", [&] {
    list_fields(fields, truth.arm);
    list_fields(fields, truth.build);
  });
  fields.number("sag_mm_per_m2", truth.arm.sag_m_per_m2, kMillimetre);
  fields.map("camera", [&] { list_fields(fields, truth.camera); });
  fields.map("drift", [&] { list_drift(fields, truth.camera); });
  fields.map("lamps", [&] {
    fields.map("lamp1", [&] { list_fields(fields, truth.lamps[0]); });
    fields.map("lamp2", [&] { list_fields(fields, truth.lamps[1]); });
  });
  list_reference_lamps(fields, truth.reference_lamps);
  fields.map("tool", [&] { list_fields(fields, truth.tool); });
  fields.map("tracker", [&] { list_fields(fields, truth.tracker); });
  list_monuments(fields, truth.build.monuments_B);
  fields.map("noise", [&] { list_fields(fields, truth.noise); });
  fields.map("board", [&] { list_fields(fields, truth.board); });
  if (fields.given("works", !truth.works.empty()))
    fields.maps("works", truth.works, [&](WorkpieceTruth& work) { list_fields(fields, work); });
  list_outliers(fields, truth.outliers);
  fields.whole_number("seed", truth.seed, std::uint32_t{0});
}

}  // namespace

Truth read_truth(const std::filesystem::path& path) {
  YamlReader reader(path, "truth");
  Truth truth;
  list_fields(reader, truth);
  reader.throw_if_faulty();
  return truth;
}

std::string truth_text(const Truth& truth) {
  YamlWriter yaml("truth", "planar-virtual-cell");
  Truth written = truth;
  list_fields(yaml, written);
  return yaml.text();
}

void write_truth(const std::filesystem::path& path, const Truth& truth) {
  write_file(path, truth_text(truth));
}

}  // namespace planar
