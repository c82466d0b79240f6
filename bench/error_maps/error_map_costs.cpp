#include <fmt/format.h>

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "alglib_peer.h"
#include "cases.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "support/error_fields.h"

namespace planar::bench {
namespace {

constexpr int kPairs = 200;
constexpr int kRounds = 50;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double peak_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// The work at one position. Its results are added up, so that the compiler cannot leave it out.
using Work = std::function<double(const Eigen::Vector2d&)>;

/// Returns the seconds per position of each work: the median of rounds in which all take turns.
std::map<std::string, double> seconds_each(const std::map<std::string, Work>& works,
                                           const std::vector<ErrorSample>& at) {
  std::map<std::string, std::vector<double>> rounds;
  double sum = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    for (const auto& [name, work] : works) {
      const double begin = now_s();
      for (const ErrorSample& sample : at) sum += work(sample.p_vision);
      rounds[name].push_back((now_s() - begin) / static_cast<double>(at.size()));
    }
  }
  if (!std::isfinite(sum)) throw std::runtime_error("a prediction is not a finite number");
  std::map<std::string, double> medians;
  for (const auto& [name, seconds] : rounds) medians[name] = median(seconds);
  return medians;
}

double exponentials(const Eigen::Vector2d& p) {
  double sum = 0.0;
  for (int i = 0; i < kPairs; ++i) sum += std::exp(-p.x() * i);
  return sum;
}

void add_map(std::map<std::string, Work>& works, const std::string& name, const ErrorMap& map) {
  works[name] = [map](const Eigen::Vector2d& p) { return predict_error(map, p).x(); };
  works[name + " with sigma"] = [map](const Eigen::Vector2d& p) { return predict(map, p).sigma; };
}

nlohmann::json time_predictions() {
  const std::vector<ErrorSample> samples = draw({"f2", "random", kPairs}, 1);
  std::vector<ErrorSample> at = truth({"f2", "random", kPairs});
  at.resize(1000);
  AlglibMap alglib(samples);
  std::map<std::string, Work> works{
      {"200 exponentials", exponentials},
      {"alglib multiquadric", [&](const Eigen::Vector2d& p) { return alglib.predict(p).x(); }}};
  for (const MapProblem& problem :
       {MapProblem{samples, MapMethod::kAuto}, MapProblem{samples, MapMethod::kRbf},
        MapProblem{draw({"f2", "random", 5000}, 1)}}) {
    const MapResult result = fit_error_map(problem);
    add_map(works, name(kind_of(result.map)), result.map);
  }
  const auto seconds = seconds_each(works, at);
  fmt::print("{:26} {:>8} {:>18}\n", "one prediction, 200 pairs", "us", "/ exponentials");
  for (const auto& [name, each] : seconds)
    fmt::print("{:26} {:8.2f} {:18.2f}\n", name, 1e6 * each, each / seconds.at("200 exponentials"));
  return seconds;
}

double error_over_noise(const ErrorMap& map, const std::vector<ErrorSample>& truth) {
  double sum = 0.0;
  for (const ErrorSample& at : truth)
    sum += (predict_error(map, at.p_vision) - at.error).squaredNorm();
  return std::sqrt(sum / (2.0 * static_cast<double>(truth.size()))) / test::kFieldNoise;
}

/// Fits maps of these sizes, which must ascend because the peak of memory only grows.
nlohmann::json fit_sizes(const std::vector<int>& sizes) {
  fmt::print("\n{:>8} {:>6} {:>8} {:>10} {:>12}\n", "pairs", "field", "fit s", "E/sigma",
             "peak MB");
  nlohmann::json rows = nlohmann::json::array();
  for (const int size : sizes) {
    for (const char* field : {"f2", "f3"}) {
      const Case c{field, "random", size};
      const std::vector<ErrorSample> samples = draw(c, 1);
      const double begin = now_s();
      const MapResult result = fit_error_map({samples});
      const double fit_s = now_s() - begin;
      const double error = error_over_noise(result.map, truth(c));
      fmt::print("{:8} {:>6} {:8.2f} {:10.3f} {:12.0f}\n", size, field, fit_s, error, peak_mb());
      std::fflush(stdout);
      rows.push_back({{"pairs", size},
                      {"field", field},
                      {"fit_s", fit_s},
                      {"error_over_noise", error},
                      {"peak_mb", peak_mb()}});
    }
  }
  return rows;
}

}  // namespace
}  // namespace planar::bench

int main(int argc, char** argv) {
  std::vector<int> sizes{5000, 20000, 100000};
  std::string json;
  CLI::App app("What error maps cost: predictions beside exponentials, fits of many pairs");
  app.add_option("--sizes", sizes, "pairs, ascending")->delimiter(',');
  app.add_option("--json", json, "file for all figures");
  CLI11_PARSE(app, argc, argv);
  // The sizes go first because the predictions' maps would count in the peak of memory.
  const nlohmann::json fits = planar::bench::fit_sizes(sizes);
  const nlohmann::json figures{{"fits", fits}, {"prediction_s", planar::bench::time_predictions()}};
  if (!json.empty()) std::ofstream(json) << figures.dump(2) << '\n';
  return 0;
}
