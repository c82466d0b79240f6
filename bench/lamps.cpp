// Centres of lamps in a window of 128 x 128 pixels: errors of ours and of other people's methods on
// clean and on defective lamps, interleaved in one run, beside the Cramer-Rao bound.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/statistics.h"
#include "core/units.h"
#include "support/center_methods.h"
#include "support/cramer_rao.h"

namespace {

using namespace planar;
using namespace planar::bench;
using Clock = std::chrono::steady_clock;

constexpr double kGradient = 0.4, kHalo = 0.25, kRim = 0.025, kCut = 0.8;

struct Family {
  std::string name;
  double amplitude{180.0}, axis_ratio{1.0}, diameter_px{40.0};
  bool gradient{false}, halo{false}, rim{false}, bite{false};

  bool is_clean() const { return !(gradient || halo || rim || bite); }
};

const std::vector<Family>& families() {
  static const std::vector<Family> all = {
      {"clean"},
      {"amplitude 60", 60.0},
      {"amplitude 400", 400.0},
      {"20 px", 180.0, 1.0, 20.0},
      {"ellipse 0.8", 180.0, 0.8},
      {"gradient", 180.0, 1.0, 40.0, true},
      {"halo", 180.0, 1.0, 40.0, false, true},
      {"irregular", 180.0, 1.0, 40.0, false, false, true},
      {"bite", 180.0, 1.0, 40.0, false, false, false, true},
      {"all four", 180.0, 1.0, 40.0, true, true, true, true},
  };
  return all;
}

DefectiveLamp draw(const Family& family, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-0.5, 0.5), blur(0.7, 1.0), turn(0.0, 2.0 * kPi);
  std::uniform_int_distribution<int> kind(0, 2);
  DefectiveLamp lamp;
  lamp.center_px = {64.0 + shift(random), 64.0 + shift(random)};
  lamp.blur_px = blur(random);
  lamp.diameter_px = family.diameter_px;
  lamp.axis_ratio = family.axis_ratio;
  lamp.amplitude = family.amplitude;
  lamp.direction_rad = turn(random);
  lamp.gradient_direction_rad = turn(random);
  lamp.gradient_kind = static_cast<GradientKind>(kind(random));
  lamp.halo_direction_rad = turn(random);
  lamp.cut_direction_rad = turn(random);
  if (family.gradient) {
    lamp.gradient = kGradient;
    lamp.amplitude = 160.0;  // keeps the bright side under 255
  }
  if (family.halo) lamp.halo = kHalo;
  if (family.rim) draw_rim(lamp, kRim, random);
  if (family.bite) lamp.cut = kCut;
  return lamp;
}

/// Squared errors per axis, and how far they are from what the method said of them.
struct Tally {
  double squares{0.0}, standardised{0.0};
  std::vector<double> times;
  int found{0}, stated{0};

  void add(const Measured& measured, const Eigen::Vector2d& truth) {
    const Eigen::Vector2d error = measured.uv_px - truth;
    squares += 0.5 * error.squaredNorm();
    ++found;
    if (!measured.covariance_px2) return;
    const Eigen::Matrix2d& P = *measured.covariance_px2;
    standardised += 0.5 * (error.x() * error.x() / P(0, 0) + error.y() * error.y() / P(1, 1));
    ++stated;
  }
  double rms_px() const { return std::sqrt(squares / found); }
  double pull() const { return std::sqrt(standardised / stated); }
};

struct Column {
  Family family;
  double bound_px{0.0};  ///< mean over the lamps; of clean lamps only
  std::vector<Tally> tallies;
};

/// The mean of the bounds at the ends of the range of blurs.
double bound_px(const Family& family, const test::Sensor& sensor) {
  double sum = 0.0;
  for (const double blur : {0.7, 1.0}) {
    const test::RenderedLamp lamp{{64.2, 63.9}, family.diameter_px, family.axis_ratio,
                                  0.4,          family.amplitude,   blur};
    sum += 0.5 * cramer_rao_px(lamp, DefectiveLamp().background, sensor);
  }
  return sum;
}

Column run(const Family& family, const std::vector<CenterMethodUnderTest>& methods, int positions,
           unsigned seed) {
  const test::Sensor sensor;
  Column column{family, family.is_clean() ? bound_px(family, sensor) : 0.0,
                std::vector<Tally>(methods.size())};
  std::mt19937 random(seed);
  for (int i = 0; i < positions; ++i) {
    const DefectiveLamp lamp = draw(family, random);
    const cv::Mat image = test::expose(render(lamp, {128, 128}), random, sensor);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      methods[m].reset(image);
      const auto begin = Clock::now();
      const std::optional<Measured> measured = methods[m].measure(image);
      column.tallies[m].times.push_back(
          std::chrono::duration<double>(Clock::now() - begin).count());
      if (measured) column.tallies[m].add(*measured, lamp.center_px);
    }
  }
  return column;
}

std::string cell(const Tally& tally, int positions) {
  if (tally.found == 0) return "none";
  const std::string rms = fmt::format("{:.4f}", tally.rms_px());
  return tally.found == positions ? rms : fmt::format("{} ({})", rms, tally.found);
}

void print_table(const std::vector<CenterMethodUnderTest>& methods,
                 const std::vector<Column>& columns, int positions) {
  std::cout << fmt::format("rms error per axis, px, {} positions; in brackets: found, if not all\n",
                           positions);
  std::cout << fmt::format("| {:22} |", "method");
  for (const Column& column : columns) std::cout << fmt::format(" {:>13} |", column.family.name);
  std::cout << "  time |\n|---|";
  for (std::size_t i = 0; i <= columns.size(); ++i) std::cout << "---|";
  std::cout << fmt::format("\n| {:22} |", "Cramer-Rao bound");
  for (const Column& column : columns) {
    std::cout << (column.bound_px > 0.0 ? fmt::format(" {:13.4f} |", column.bound_px)
                                        : fmt::format(" {:>13} |", ""));
  }
  std::cout << "       |\n";
  const double unit = median(columns[0].tallies[1].times);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    std::cout << fmt::format("| {:22} |", methods[m].name);
    for (const Column& column : columns) {
      const Tally& tally = column.tallies[m];
      std::cout << fmt::format(" {:>13} |", cell(tally, positions));
    }
    std::cout << fmt::format(" {:5.2f} |\n", median(columns[0].tallies[m].times) / unit);
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (columns[0].tallies[m].stated == 0) continue;
    std::cout << fmt::format("| {:22} |", methods[m].name + ", pull");
    for (const Column& column : columns) {
      const Tally& tally = column.tallies[m];
      std::cout << fmt::format(" {:>13} |",
                               tally.stated > 0 ? fmt::format("{:.2f}", tally.pull()) : "");
    }
    std::cout << "       |\n";
  }
  std::cout << fmt::format(
      "time: median over that of vpDot2.track, {:.3f} ms, on clean lamps; "
      "pull: rms of error over stated standard deviation\n",
      1e3 * unit);
}

nlohmann::json as_json(const std::vector<CenterMethodUnderTest>& methods,
                       const std::vector<Column>& columns, int positions, unsigned seed) {
  nlohmann::json json{{"positions", positions}, {"seed", seed}};
  for (const Column& column : columns) {
    nlohmann::json& family = json["families"][column.family.name];
    if (column.bound_px > 0.0) family["cramer_rao_px"] = column.bound_px;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const Tally& tally = column.tallies[m];
      nlohmann::json& entry = family["methods"][methods[m].name];
      entry = {{"found", tally.found},
               {"median_s", median(tally.times)},
               {"time_over_vp_dot2", median(tally.times) / median(column.tallies[1].times)}};
      if (tally.found > 0) entry["rms_px"] = tally.rms_px();
      if (tally.stated > 0) entry["pull"] = tally.pull();
    }
  }
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Measures lamp centres by our and by other methods and prints their errors"};
  int positions = 400;
  unsigned seed = 1;
  std::string json_file;
  app.add_option("--positions", positions, "lamps per family")->check(CLI::PositiveNumber);
  app.add_option("--seed", seed, "of the random numbers");
  app.add_option("--json", json_file, "file for the results");
  CLI11_PARSE(app, argc, argv);

  cv::setNumThreads(1);
  const std::vector<CenterMethodUnderTest> methods = center_methods();
  std::vector<Column> columns;
  for (const Family& family : families()) columns.push_back(run(family, methods, positions, seed));
  print_table(methods, columns, positions);
  if (!json_file.empty()) {
    std::ofstream out(json_file);
    out << as_json(methods, columns, positions, seed).dump(2) << "\n";
    if (!out) {
      std::cerr << "cannot write " << json_file << "\n";
      return 1;
    }
  }
  return 0;
}
