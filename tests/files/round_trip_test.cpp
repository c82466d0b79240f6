#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/purpose.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

constexpr int kTables = 20;
constexpr int kRows = 20;

class Random {
 public:
  explicit Random(unsigned seed) : random_(seed) {}

  int below(int n) { return std::uniform_int_distribution<>(0, n - 1)(random_); }
  bool coin() { return below(2) == 0; }
  /// Metres or radians, of the size of those in a cell, in whole nanometres.
  double number() {
    return std::round(1e9 * std::uniform_real_distribution<>(-0.7, 0.7)(random_)) * 1e-9;
  }
  Eigen::Vector2d point() { return {number(), number()}; }
  Joints joints() { return {number(), number(), number()}; }
  std::optional<double> optional_number() {
    return coin() ? std::optional<double>(number()) : std::nullopt;
  }
  std::optional<Eigen::Vector2d> optional_point() {
    return coin() ? std::optional<Eigen::Vector2d>(point()) : std::nullopt;
  }
  std::optional<std::array<Eigen::Vector2d, 2>> optional_lamps() {
    if (coin()) return std::nullopt;
    return std::array{point(), point()};
  }
  std::string text() {
    constexpr const char* kParts[] = {"a,b.png", ",", "\"", "#", " ", "\n",      ":",
                                      "no",      "1", "'",  "-", ";", "\xC3\xA9"};
    std::string text;
    for (int i = below(5); i > 0; --i) text += kParts[below(static_cast<int>(std::size(kParts)))];
    return text;
  }
  /// One that no other row has, and a file's name could be.
  std::string id() { return text() + std::to_string(++ids_); }
  template <typename Value, std::size_t kSize>
  Value one_of(const Named<Value> (&table)[kSize]) {
    return table[below(static_cast<int>(kSize))].value;
  }
  Purpose plan() { return kPurposes[2 + below(7)].value; }

 private:
  std::mt19937 random_;
  int ids_{0};
};

/// What is written has so many decimals that a row read and written again is the same text: the
/// columns and their units agree in both directions.
template <typename Row, typename Draw, typename Write, typename Read>
void check_table(const Draw& draw, const Write& text_of, const Read& read) {
  const test::TemporaryFolder folder;
  for (unsigned seed = 1; seed <= kTables; ++seed) {
    Random random(seed);
    std::vector<Row> rows;
    rows.reserve(kRows);
    for (int i = 0; i < kRows; ++i) rows.push_back(draw(random));
    const std::string text = text_of(rows);
    const std::vector<Row> back = read(folder.write("frames.csv", text));
    REQUIRE(back.size() == rows.size());
    CHECK(text_of(back) == text);
  }
}

template <typename Row>
auto lines(std::string (*header)(), std::string (*line)(const Row&)) {
  return [=](const std::vector<Row>& rows) {
    std::string text = header();
    for (const Row& row : rows) text += line(row);
    return text;
  };
}

TEST_CASE("Every table comes back as it was written, whatever its texts contain") {
  SECTION("pairs") {
    const auto draw = [](Random& random) {
      return PairRow{random.id(),
                     random.point(),
                     random.optional_point(),
                     random.optional_number(),
                     random.optional_number(),
                     random.optional_number(),
                     random.coin() ? std::optional<Purpose>(random.plan()) : std::nullopt,
                     random.coin() ? random.id() : "",
                     random.optional_lamps(),
                     random.optional_point(),
                     random.optional_number(),
                     random.coin() ? std::optional<Joints>(random.joints()) : std::nullopt,
                     random.optional_number()};
    };
    const auto read = [](const auto& path) { return read_pairs(path); };
    check_table<PairRow>(
        draw, [](const auto& rows) { return pairs_text(rows); }, read);
  }
  SECTION("plan") {
    const auto draw = [](Random& random) {
      PlanRow row{random.id(), random.plan(), random.joints()};
      if (random.coin()) row.where = TipPose{random.point(), random.number()};
      return row;
    };
    check_table<PlanRow>(draw, plan_text, [](const auto& path) { return read_plan(path, 0.0); });
  }
  SECTION("frames") {
    const auto draw = [](Random& random) {
      const cv::Rect region(random.below(5000), random.below(5000), random.below(512), 512);
      const Pulses pulses(random.below(9), -random.below(1000000), random.below(9));
      return FrameRow{random.id(),   random.text(),   1.5 * random.below(100),
                      random.plan(), random.joints(), pulses,
                      region};
    };
    const auto read = [](const auto& path) { return read_frames(path.parent_path()); };
    check_table<FrameRow>(draw, lines(frames_header, frame_line), read);
  }
  SECTION("tracker") {
    const auto draw = [](Random& random) {
      return TrackerRow{random.id(), 0.25 * random.below(100), 10.0 * random.joints()};
    };
    check_table<TrackerRow>(draw, lines(tracker_header, tracker_line),
                            [](const auto& path) { return read_tracker(path); });
  }
  SECTION("targets") {
    const auto draw = [](Random& random) {
      return TargetRow{random.id(), random.point(), random.optional_number()};
    };
    check_table<TargetRow>(draw, lines(targets_header, target_line), read_targets);
  }
  SECTION("lamps") {
    const auto draw = [](Random& random) {
      LampRow row;
      row.id = random.id();
      row.image = random.text();
      row.status = random.one_of(kLampStatuses);
      row.t_s = random.optional_number();
      for (int i = random.below(3); i > 0; --i) {
        row.uv_px.push_back(3000.0 * random.point());
        row.covariance_px2.push_back(1e-4 * Eigen::Matrix2d::Constant(1.0 + random.number()));
      }
      row.p_vision = random.optional_point();
      row.phi = random.optional_number();
      row.sigma = random.optional_point();
      return row;
    };
    check_table<LampRow>(
        draw, [](const auto& rows) { return lamps_text(rows); }, read_lamps);
  }
  SECTION("results") {
    const auto draw = [](Random& random) {
      TargetResult result;
      result.id = random.text();
      result.p_d = random.point();
      result.status = random.one_of(kServoStatuses);
      result.reason = random.text();
      result.iterations = random.below(12);
      result.seconds = 0.125 * random.below(100);
      for (auto* error : {&result.before_own, &result.after_own, &result.before_judged,
                          &result.after_judged, &result.vision_raw, &result.vision_compensated})
        *error = random.optional_point();
      result.uncertainty_m = random.optional_number();
      result.sigma_judged_m = random.optional_number();
      result.not_judged = random.text();
      result.believed = random.optional_point();
      result.phi_d = random.optional_number();
      result.sigma_target_m = std::abs(random.number());
      return result;
    };
    check_table<TargetResult>(draw,
                              lines(
                                  +[] { return results_header(); }, result_line),
                              read_results);
  }
}

TEST_CASE("Settings come back as they were written") {
  const test::TemporaryFolder folder;
  constexpr double kUnitRounding = 1e-14;
  for (unsigned seed = 1; seed <= kTables; ++seed) {
    Random random(seed);
    std::string name = random.text();
    std::replace(name.begin(), name.end(), '\n', '-');
    const std::vector<Origin> inputs{origin_of({Role::kLamps, folder.write("in" + name, name)})};

    ToolOffsets tool;
    tool.p_TP = random.point();
    tool.p_TS = random.joints();
    tool.covariance = tool.covariance.Identity() * 1e-12;
    tool.covariance(0, 3) = tool.covariance(3, 0) = 1e-13 * random.number();
    const std::string tool_file = tool_text(tool, random.text(), inputs);
    const ToolOffsets tool_back = read_tool(folder.write("tool.yaml", tool_file));
    CHECK(tool_back.p_TP.isApprox(tool.p_TP, kUnitRounding));
    CHECK(tool_back.p_TS.isApprox(tool.p_TS, kUnitRounding));
    CHECK(tool_back.covariance.isApprox(tool.covariance, kUnitRounding));
    CHECK(tool_file.find(sha256(name)) != std::string::npos);

    WorkplaneRecord plane;
    plane.X_WC.linear() = rotation_from_vector(0.3 * random.joints()) *
                          Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal().toDenseMatrix();
    plane.X_WC.translation() = Eigen::Vector3d(random.number(), random.number(), 1.0);
    plane.covariance.diagonal().setConstant(1e-9);
    plane.source = random.one_of(kWorkplaneSources);
    plane.absorbed = random.below(7);
    plane.pairs = random.below(1000);
    plane.rms = std::abs(random.number());
    plane.reference_lamps.resize(static_cast<std::size_t>(random.below(3)));
    for (ReferenceLamp& lamp : plane.reference_lamps)
      lamp = {random.text(), random.point(), std::abs(random.number())};
    const auto file = folder.write("workplane.yaml", workplane_text(plane, random.text(), inputs));
    const WorkplaneRecord plane_back = read_workplane(file);
    CHECK(plane_back.X_WC.matrix().isApprox(plane.X_WC.matrix(), kUnitRounding));
    CHECK(plane_back.covariance.isApprox(plane.covariance, kUnitRounding));
    CHECK(plane_back.source == plane.source);
    CHECK(plane_back.absorbed == plane.absorbed);
    CHECK(plane_back.pairs == plane.pairs);
    CHECK(plane_back.rms == Approx(plane.rms).epsilon(kUnitRounding));
    REQUIRE(plane_back.reference_lamps.size() == plane.reference_lamps.size());
    for (std::size_t i = 0; i < plane.reference_lamps.size(); ++i) {
      const ReferenceLamp &lamp_back = plane_back.reference_lamps[i],
                          &lamp = plane.reference_lamps[i];
      CHECK(lamp_back.id == lamp.id);
      CHECK(lamp_back.uv_px == lamp.uv_px);
      CHECK(lamp_back.sigma_px == lamp.sigma_px);
    }
  }
}

}  // namespace
}  // namespace planar
