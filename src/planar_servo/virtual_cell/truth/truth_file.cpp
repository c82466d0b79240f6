#include "planar_servo/virtual_cell/truth/truth_file.h"

#include <array>
#include <cmath>
#include <string>

#include "planar_servo/core/units.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {
namespace {

// Numbers in the file's unit times `unit` are SI.

double positive(const YamlNode& node, const std::string& key, double unit) {
  return node.positive(key) * unit;
}

double not_negative(const YamlNode& node, const std::string& key, double unit) {
  return node.number_in(key, 0.0) * unit;
}

template <int kSize>
Eigen::Matrix<double, kSize, 1> vector(const YamlNode& node, const std::string& key, double unit) {
  const std::vector<double> numbers = node.numbers(key, kSize);
  return unit * Eigen::Map<const Eigen::Matrix<double, kSize, 1>>(numbers.data());
}

std::vector<double> row(const Eigen::VectorXd& values, double unit) {
  const Eigen::VectorXd scaled = values / unit;
  return {scaled.begin(), scaled.end()};
}

Pose read_pose(const YamlNode& node) {
  const Eigen::Vector4d wxyz = vector<4>(node, "quaternion_wxyz", 1.0);
  constexpr double kUnitLength = 1e-3;
  if (std::abs(wxyz.norm() - 1.0) > kUnitLength)
    node.add_fault("quaternion_wxyz has not the length 1 of a rotation");
  Pose pose = Pose::Identity();
  pose.translation() = vector<3>(node, "translation_mm", kMillimetre);
  pose.linear() =
      Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix();
  return pose;
}

void write_pose(YamlWriter& yaml, const std::string& key, const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  yaml.begin_map(key)
      .add("translation_mm", row(pose.translation(), kMillimetre))
      .add("quaternion_wxyz", std::vector<double>{q.w(), q.x(), q.y(), q.z()})
      .end_map();
}

/// Rows of [amplitude, phase_deg, harmonic].
std::vector<Harmonic> read_harmonics(const YamlNode& node, const std::string& key, double unit) {
  std::vector<Harmonic> harmonics;
  for (const YamlNode& item : node.list(key)) {
    const auto row = item.as_numbers(3);
    if (!row) continue;
    const double order = (*row)[2];
    if (order != std::floor(order) || order < 0.0 || order > 1000.0)
      item.add_fault("a harmonic's number must be whole and not negative");
    else
      harmonics.push_back({(*row)[0] * unit, (*row)[1] * kDegree, static_cast<int>(order)});
  }
  return harmonics;
}

std::vector<std::vector<double>> harmonic_rows(const std::vector<Harmonic>& harmonics,
                                               double unit) {
  std::vector<std::vector<double>> rows;
  rows.reserve(harmonics.size());
  for (const Harmonic& h : harmonics)
    rows.push_back({h.amplitude / unit, h.phase_rad / kDegree, static_cast<double>(h.order)});
  return rows;
}

constexpr std::array<const char*, 3> kJoints{"joint1", "joint2", "joint3"};

ArmTruth read_arm(const YamlNode& node) {
  ArmTruth arm;
  const Eigen::Vector2d lengths = vector<2>(node, "link_lengths_mm", kMillimetre);
  if (!(lengths.array() > 0.0).all()) node.add_fault("link_lengths_mm must be positive");
  arm.link_lengths_m = {lengths[0], lengths[1]};
  const Eigen::Vector3d zeros = vector<3>(node, "zero_offsets_deg", kDegree);
  const Eigen::Vector3d backlash = vector<3>(node, "backlash_deg", kDegree);
  if (!(backlash.array() >= 0.0).all()) node.add_fault("backlash_deg must not be negative");
  const YamlNode eccentricity = node.child("eccentricity");
  for (std::size_t i = 0; i < 3; ++i)
    arm.reducers[i] = {zeros[static_cast<int>(i)], backlash[static_cast<int>(i)],
                       read_harmonics(eccentricity, kJoints[i], kDegree)};
  return arm;
}

void write_arm(YamlWriter& yaml, const ArmTruth& arm) {
  const auto& [r1, r2, r3] = arm.reducers;
  yaml.begin_map("arm")
      .add("link_lengths_mm",
           row(Eigen::Vector2d(arm.link_lengths_m[0], arm.link_lengths_m[1]), kMillimetre))
      .add(
          "zero_offsets_deg",
          row(Eigen::Vector3d(r1.zero_offset_rad, r2.zero_offset_rad, r3.zero_offset_rad), kDegree))
      .add("backlash_deg",
           row(Eigen::Vector3d(r1.backlash_rad, r2.backlash_rad, r3.backlash_rad), kDegree))
      .begin_map("eccentricity");
  for (std::size_t i = 0; i < 3; ++i)
    yaml.add(kJoints[i], harmonic_rows(arm.reducers[i].eccentricity, kDegree));
  yaml.end_map().end_map();
  yaml.add("sag_mm_per_m2", arm.sag_m_per_m2 / kMillimetre);
}

CameraTruth read_camera(const YamlNode& node) {
  CameraTruth camera;
  camera.X_CB = read_pose(node.child("X_CB"));
  camera.focal_px = vector<2>(node, "focal_px", 1.0);
  if (!(camera.focal_px.array() > 0.0).all()) node.add_fault("focal_px must be positive");
  camera.center_px = vector<2>(node, "center_px", 1.0);
  const YamlNode lens = node.child("lens");
  const std::vector<double> radial = lens.numbers("radial", 3);
  camera.radial = {radial[0], radial[1], radial[2]};
  const std::vector<double> decentring = lens.numbers("decentring", 2);
  camera.decentring = {decentring[0], decentring[1]};
  for (const YamlNode& item : node.list("warp")) {
    const auto numbers = item.as_numbers(5);
    if (!numbers) continue;
    const std::vector<double>& bump = *numbers;
    if (!(bump[2] > 0.0)) item.add_fault("a bump's sigma must be positive");
    camera.warp.push_back({{bump[0], bump[1]}, bump[2], {bump[3], bump[4]}});
  }
  camera.blur_px = node.number_in("blur_px", 0.1, 20.0);
  return camera;
}

void write_camera(YamlWriter& yaml, const CameraTruth& camera) {
  const auto& [a1, a2, a3] = camera.radial;
  const auto& [p1, p2] = camera.decentring;
  std::vector<std::vector<double>> warp;
  for (const WarpBump& bump : camera.warp)
    warp.push_back({bump.center_px.x(), bump.center_px.y(), bump.sigma_px, bump.amplitude_px.x(),
                    bump.amplitude_px.y()});
  yaml.begin_map("camera");
  write_pose(yaml, "X_CB", camera.X_CB);
  yaml.add("focal_px", row(camera.focal_px, 1.0))
      .add("center_px", row(camera.center_px, 1.0))
      .begin_map("lens")
      .add("radial", std::vector<double>{a1, a2, a3})
      .add("decentring", std::vector<double>{p1, p2})
      .end_map()
      .add("blur_px", camera.blur_px)
      .add("warp", warp)
      .end_map();
}

LampTruth read_lamp(const YamlNode& node) {
  LampTruth lamp;
  lamp.diameter_m = positive(node, "diameter_mm", kMillimetre);
  lamp.peak_level = not_negative(node, "peak_level", 1.0);
  const YamlNode glow = node.child("glow");
  lamp.glow.gradient_tool = vector<2>(glow, "gradient_tool", 1.0);
  lamp.glow.gradient_view = glow.number("gradient_view");
  lamp.glow.halo_tool = vector<2>(glow, "halo_tool", 1.0);
  lamp.glow.halo_view = glow.number("halo_view");
  lamp.glow.halo_decay_m = positive(glow, "halo_decay_mm", kMillimetre);
  lamp.rim = read_harmonics(node, "rim_harmonics", 1.0);
  return lamp;
}

void write_lamp(YamlWriter& yaml, const std::string& key, const LampTruth& lamp) {
  yaml.begin_map(key)
      .add("diameter_mm", lamp.diameter_m / kMillimetre)
      .add("peak_level", lamp.peak_level)
      .begin_map("glow")
      .add("gradient_tool", row(lamp.glow.gradient_tool, 1.0))
      .add("gradient_view", lamp.glow.gradient_view)
      .add("halo_tool", row(lamp.glow.halo_tool, 1.0))
      .add("halo_view", lamp.glow.halo_view)
      .add("halo_decay_mm", lamp.glow.halo_decay_m / kMillimetre)
      .end_map()
      .add("rim_harmonics", harmonic_rows(lamp.rim, 1.0))
      .end_map();
}

ToolTruth read_tool(const YamlNode& node) {
  ToolTruth tool;
  tool.lamps_m[0] = vector<2>(node, "lamp1_mm", kMillimetre);
  tool.lamps_m[1] = vector<2>(node, "lamp2_mm", kMillimetre);
  tool.lamp_height_m = node.number("lamp_height_mm") * kMillimetre;
  tool.reflector_m = vector<3>(node, "reflector_mm", kMillimetre);
  return tool;
}

void write_tool(YamlWriter& yaml, const ToolTruth& tool) {
  yaml.begin_map("tool")
      .add("lamp1_mm", row(tool.lamps_m[0], kMillimetre))
      .add("lamp2_mm", row(tool.lamps_m[1], kMillimetre))
      .add("lamp_height_mm", tool.lamp_height_m / kMillimetre)
      .add("reflector_mm", row(tool.reflector_m, kMillimetre))
      .end_map();
}

TrackerTruth read_tracker(const YamlNode& node) {
  return {read_pose(node.child("X_LB")), not_negative(node, "sigma_mm", kMillimetre),
          not_negative(node, "bias_mm", kMillimetre),
          positive(node, "bias_wavelength_mm", kMillimetre)};
}

void write_tracker(YamlWriter& yaml, const TrackerTruth& tracker) {
  yaml.begin_map("tracker");
  write_pose(yaml, "X_LB", tracker.X_LB);
  yaml.add("sigma_mm", tracker.sigma_m / kMillimetre)
      .add("bias_mm", tracker.bias_m / kMillimetre)
      .add("bias_wavelength_mm", tracker.bias_wavelength_m / kMillimetre)
      .end_map();
}

NoiseTruth read_noise(const YamlNode& node) {
  return {not_negative(node, "background_level", 1.0), positive(node, "gain_e_per_level", 1.0),
          not_negative(node, "read_noise_levels", 1.0)};
}

BoardTruth read_board(const YamlNode& node) {
  return {node.whole_number_in("columns", 2, 100), node.whole_number_in("rows", 2, 100),
          positive(node, "pitch_mm", kMillimetre), positive(node, "dot_diameter_mm", kMillimetre),
          not_negative(node, "bright_level", 1.0), not_negative(node, "dark_level", 1.0)};
}

void write_noise_and_board(YamlWriter& yaml, const NoiseTruth& noise, const BoardTruth& board) {
  yaml.begin_map("noise")
      .add("background_level", noise.background_level)
      .add("gain_e_per_level", noise.gain_e_per_level)
      .add("read_noise_levels", noise.read_noise_levels)
      .end_map();
  yaml.begin_map("board")
      .add("columns", board.columns)
      .add("rows", board.rows)
      .add("pitch_mm", board.pitch_m / kMillimetre)
      .add("dot_diameter_mm", board.dot_diameter_m / kMillimetre)
      .add("bright_level", board.bright_level)
      .add("dark_level", board.dark_level)
      .end_map();
}

}  // namespace

Truth read_truth(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read(path, "truth");
  const YamlNode root = document.root();
  Truth truth;
  truth.arm = read_arm(root.child("arm"));
  truth.arm.sag_m_per_m2 = root.number("sag_mm_per_m2") * kMillimetre;
  truth.camera = read_camera(root.child("camera"));
  truth.camera.drift_px_per_h = vector<2>(root.child("drift"), "px_per_h", 1.0);
  const YamlNode lamps = root.child("lamps");
  truth.lamps = {read_lamp(lamps.child("lamp1")), read_lamp(lamps.child("lamp2"))};
  truth.tool = read_tool(root.child("tool"));
  truth.tracker = read_tracker(root.child("tracker"));
  truth.noise = read_noise(root.child("noise"));
  truth.board = read_board(root.child("board"));
  truth.seed = static_cast<std::uint32_t>(root.number_in("seed", 0.0, 4294967295.0));
  document.throw_if_faulty();
  return truth;
}

std::string truth_text(const Truth& truth) {
  YamlWriter yaml = YamlWriter::with_header("truth", "planar-virtual-cell");
  write_arm(yaml, truth.arm);
  write_camera(yaml, truth.camera);
  yaml.begin_map("drift").add("px_per_h", row(truth.camera.drift_px_per_h, 1.0)).end_map();
  yaml.begin_map("lamps");
  write_lamp(yaml, "lamp1", truth.lamps[0]);
  write_lamp(yaml, "lamp2", truth.lamps[1]);
  yaml.end_map();
  write_tool(yaml, truth.tool);
  write_tracker(yaml, truth.tracker);
  write_noise_and_board(yaml, truth.noise, truth.board);
  yaml.add("seed", static_cast<double>(truth.seed));
  return yaml.text();
}

void write_truth(const std::filesystem::path& path, const Truth& truth) {
  write_file(path, truth_text(truth));
}

}  // namespace planar
