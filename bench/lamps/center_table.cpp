#include "lamps/center_table.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "lamps/center_methods.h"
#include "lamps/cramer_rao.h"
#include "planar_servo/base/core/statistics.h"

namespace planar::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Methods = std::vector<CenterMethodUnderTest>;

constexpr std::size_t kOurs = 0, kTimeUnit = 1;  // indices in center_methods()
constexpr int kBoundedLamps = 24;  // number of lamps over which the bounds are averaged

/// Adds up squared errors per axis, and how far they are from what the method said of them.
struct Tally {
  double squares{0.0}, standardised{0.0};
  std::vector<double> errors, times;
  int found{0}, stated{0};

  void add(const Measured& measured, const Eigen::Vector2d& truth) {
    const Eigen::Vector2d error = measured.uv_px - truth;
    squares += 0.5 * error.squaredNorm();
    errors.push_back(error.norm());
    ++found;
    if (!measured.covariance_px2) return;
    const Eigen::Matrix2d& P = *measured.covariance_px2;
    standardised += 0.5 * (error.x() * error.x() / P(0, 0) + error.y() * error.y() / P(1, 1));
    ++stated;
  }
  double rms_px() const { return std::sqrt(squares / found); }
  double pull() const { return std::sqrt(standardised / stated); }
};

/// Holds the bounds of clean lamps; they are zero for other lamps.
struct Bounds {
  double of_seven_px{0.0}, of_model_px{0.0};
};

struct Column {
  std::string family;
  Bounds bounds;
  std::vector<Tally> tallies;
};

void measure_all(const Methods& methods, const cv::Mat& image, const Eigen::Vector2d& truth,
                 std::vector<Tally>& tallies) {
  for (std::size_t m = 0; m < methods.size(); ++m) {
    methods[m].reset(image);
    methods[m].measure(image);  // warms up code and window, as in a running loop
    const auto begin = Clock::now();
    const std::optional<Measured> measured = methods[m].measure(image);
    tallies[m].times.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
    if (measured) tallies[m].add(*measured, truth);
  }
}

Column run(const LampFamily& family, const Methods& methods, int positions, unsigned seed) {
  const test::Sensor sensor;
  Column column{family.name, {}, std::vector<Tally>(methods.size())};
  std::mt19937 random(seed);
  double of_seven = 0.0, of_model = 0.0;
  int bounded = 0;
  for (int i = 0; i < positions; ++i) {
    const LampSample sample = family.draw(random);
    measure_all(methods, test::expose(sample.scene, random, sensor), sample.center_px,
                column.tallies);
    if (!sample.clean || bounded == kBoundedLamps) continue;
    ++bounded;
    of_seven += cramer_rao_variance_px2(*sample.clean, kBackground, sensor);
    of_model += cramer_rao_variance_px2(*sample.clean, kBackground, sensor, unknown_to_ours());
  }
  if (bounded > 0) column.bounds = {std::sqrt(of_seven / bounded), std::sqrt(of_model / bounded)};
  return column;
}

std::string cell(const Tally& tally) {
  if (tally.found == 0) return "none";
  const std::string rms = fmt::format("{:.4f}", tally.rms_px());
  const bool all = tally.found == static_cast<int>(tally.times.size());
  return all ? rms : fmt::format("{} ({})", rms, tally.found);
}

template <typename Cell>
void print_row(const std::string& name, const std::vector<Column>& columns, const Cell& cell_of,
               const std::string& time = "") {
  fmt::print("| {:24} |", name);
  for (const Column& column : columns) fmt::print(" {:>13} |", cell_of(column));
  fmt::print(" {:>5} |\n", time);
}

std::string number(double value, int digits) {
  return value > 0.0 ? fmt::format("{:.{}f}", value, digits) : "";
}

void print_bounds(const std::vector<Column>& columns) {
  print_row("Cramer-Rao, 7 unknowns", columns,
            [](const Column& c) { return number(c.bounds.of_seven_px, 4); });
  print_row("Cramer-Rao, our model", columns,
            [](const Column& c) { return number(c.bounds.of_model_px, 4); });
  const auto ratio = [](const Column& c, double bound) {
    return bound > 0.0 && c.tallies[kOurs].found > 0
               ? fmt::format("{:.2f}", c.tallies[kOurs].rms_px() / bound)
               : "";
  };
  print_row("ours / 7 unknowns", columns,
            [&](const Column& c) { return ratio(c, c.bounds.of_seven_px); });
  print_row("ours / our model", columns,
            [&](const Column& c) { return ratio(c, c.bounds.of_model_px); });
}

void print_table(const Methods& methods, const std::vector<Column>& columns, int positions) {
  fmt::print("rms error per axis, px, {} positions; in brackets: found, if not all\n", positions);
  print_row(
      "method", columns, [](const Column& c) { return c.family; }, "time");
  fmt::print("|---|");
  for (std::size_t i = 0; i <= columns.size(); ++i) fmt::print("---|");
  fmt::print("\n");
  print_bounds(columns);
  const double unit = median(columns[0].tallies[kTimeUnit].times);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    print_row(
        methods[m].name, columns, [&](const Column& c) { return cell(c.tallies[m]); },
        fmt::format("{:.2f}", median(columns[0].tallies[m].times) / unit));
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (columns[0].tallies[m].stated == 0) continue;
    print_row(methods[m].name + ", pull", columns, [&](const Column& c) {
      return c.tallies[m].stated > 0 ? fmt::format("{:.2f}", c.tallies[m].pull()) : "";
    });
  }
  fmt::print(
      "time: median over that of {}, {:.3f} ms, on {} lamps; "
      "pull: rms of error over stated standard deviation\n",
      methods[kTimeUnit].name, 1e3 * unit, columns[0].family);
}

nlohmann::json as_json(const Methods& methods, const std::vector<Column>& columns) {
  nlohmann::json json;
  for (const Column& column : columns) {
    nlohmann::json& family = json[column.family];
    if (column.bounds.of_seven_px > 0.0) {
      family["cramer_rao_px"] = column.bounds.of_seven_px;
      family["cramer_rao_of_our_model_px"] = column.bounds.of_model_px;
    }
    const double unit = median(column.tallies[kTimeUnit].times);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const Tally& tally = column.tallies[m];
      nlohmann::json& entry = family["methods"][methods[m].name];
      entry = {{"found", tally.found},
               {"median_s", median(tally.times)},
               {"time_over_vp_dot2", median(tally.times) / unit}};
      if (tally.found > 0) {
        entry["rms_px"] = tally.rms_px();
        entry["median_error_px"] = median(tally.errors);
      }
      if (tally.stated > 0) entry["pull"] = tally.pull();
    }
  }
  return json;
}

}  // namespace

nlohmann::json measure_centers(const std::vector<LampFamily>& families, int positions,
                               unsigned seed) {
  const Methods methods = center_methods();
  std::vector<Column> columns;
  columns.reserve(families.size());
  for (const LampFamily& family : families)
    columns.push_back(run(family, methods, positions, seed));
  print_table(methods, columns, positions);
  return as_json(methods, columns);
}

}  // namespace planar::bench
