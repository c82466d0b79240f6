#include <fmt/format.h>

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "alglib_peer.h"
#include "cases.h"
#include "dlib_peer.h"
#include "peer.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "scipy_peer.h"
#include "support/error_fields.h"

namespace planar::bench {
namespace {

using Scores = std::map<std::string, std::vector<Score>>;

constexpr double kHandWidth = 48.0 * kMillimetre;
constexpr double kNormal95 = 1.959964;

struct Options {
  std::vector<std::string> fields{"f1", "f2", "f3", "f4", "f5"};
  std::vector<std::string> layouts{"rings", "random", "grid"};
  int count{200};
  int draws{10};
  std::uint32_t first_seed{1};
  std::string json;
};

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Times and judges a method. `fit` returns a function from position to predicted error.
template <typename Fit>
Score score(const std::vector<ErrorSample>& truth, Fit&& fit) {
  const double begin = now_s();
  auto predict_error = fit();
  const double fitted = now_s();
  double sum = 0.0;
  for (const ErrorSample& at : truth) sum += (predict_error(at.p_vision) - at.error).squaredNorm();
  const double predicted = now_s();
  const auto n = static_cast<double>(truth.size());
  return {std::sqrt(sum / (2.0 * n)) / test::kFieldNoise, fitted - begin, (predicted - fitted) / n};
}

/// Scores one of our maps. NaN where the equations cannot be solved, as with a hand width without a
/// ridge on close points.
Score score_ours(const MapProblem& problem, const std::vector<ErrorSample>& truth) {
  try {
    return score(truth, [&] {
      return [map = fit_error_map(problem).map](const Eigen::Vector2d& p) {
        return predict_error(map, p);
      };
    });
  } catch (const WorkError&) {
    return {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  }
}

template <typename Peer>
Score score_peer(const std::vector<ErrorSample>& samples, const std::vector<ErrorSample>& truth) {
  return score(truth, [&] {
    return [map = std::make_shared<Peer>(samples)](const Eigen::Vector2d& p) {
      return map->predict(p);
    };
  });
}

/// Returns the share of the noise-free errors within the stated 95 % intervals, axis by axis.
double coverage(const ErrorMap& map, const std::vector<ErrorSample>& truth) {
  Eigen::Index covered = 0;
  for (const ErrorSample& at : truth) {
    const ErrorPrediction prediction = predict(map, at.p_vision);
    covered +=
        ((prediction.error - at.error).array().abs() <= kNormal95 * prediction.sigma).count();
  }
  return static_cast<double>(covered) / (2.0 * static_cast<double>(truth.size()));
}

struct CaseResult {
  Case c;
  Scores scores;
  double coverage{0.0};  ///< mean over draws of the automatic choice's coverage
  double rejected{0.0};  ///< mean over draws of the number of pairs that it rejected
};

CaseResult run(const Case& c, int draws, std::uint32_t first_seed) {
  CaseResult result{c, {}, 0.0, 0.0};
  const std::vector<ErrorSample> test = truth(c);
  std::vector<std::vector<ErrorSample>> samples;
  for (int i = 0; i < draws; ++i) {
    samples.push_back(draw(c, first_seed + static_cast<std::uint32_t>(i)));
    const auto& drawn = samples.back();
    auto& scores = result.scores;
    scores["idw"].push_back(score_ours({drawn, MapMethod::kIdw}, test));
    scores["hand 48 mm"].push_back(score_ours({drawn, MapMethod::kHandWidth, kHandWidth}, test));
    scores["rbf"].push_back(score_ours({drawn, MapMethod::kRbf}, test));
    scores["auto"].push_back(score_ours({drawn, MapMethod::kAuto}, test));
    scores["alglib multiquadric"].push_back(score_peer<AlglibMap>(drawn, test));
    scores["dlib gaussian"].push_back(score_peer<DlibMap>(drawn, test));
    const MapResult chosen = fit_error_map({drawn});
    result.coverage += coverage(chosen.map, test) / draws;
    result.rejected += static_cast<double>(chosen.rejected.size()) / draws;
  }
  result.scores.merge(run_scipy(
      samples, test,
      std::filesystem::temp_directory_path() / fmt::format("bench_error_maps_{}", getpid())));
  return result;
}

template <typename Member>
std::vector<double> values_of(const std::vector<Score>& scores, Member member) {
  std::vector<double> values;
  for (const Score& score : scores) values.push_back(score.*member);
  return values;
}

double mean_error(const CaseResult& result, const std::string& method) {
  return mean(values_of(result.scores.at(method), &Score::error_over_noise));
}

bool is_peer(const std::string& method) {
  return method.rfind("alglib", 0) == 0 || method.rfind("dlib", 0) == 0 ||
         method.rfind("scipy", 0) == 0;
}

double best_peer_error(const CaseResult& result) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& entry : result.scores)
    if (is_peer(entry.first)) best = std::min(best, mean_error(result, entry.first));
  return best;
}

void print_case(const CaseResult& result) {
  const double ours = mean_error(result, "auto");
  fmt::print(
      "\n{} {}: auto over best peer {:.3f}, over rbf {:.3f}; coverage {:.3f}; rejected {:.1f}\n",
      result.c.field, result.c.layout, ours / best_peer_error(result),
      ours / mean_error(result, "rbf"), result.coverage, result.rejected);
  for (const auto& [method, scores] : result.scores)
    fmt::print("  {:24} E/sigma {:6.3f}   fit {:8.1f} ms   predict {:7.2f} us\n", method,
               mean_error(result, method), 1e3 * median(values_of(scores, &Score::fit_s)),
               1e6 * median(values_of(scores, &Score::predict_s)));
  std::fflush(stdout);
}

nlohmann::json figures(const CaseResult& result) {
  nlohmann::json methods;
  for (const auto& [method, scores] : result.scores)
    methods[method] = {{"error_over_noise", values_of(scores, &Score::error_over_noise)},
                       {"fit_s", median(values_of(scores, &Score::fit_s))},
                       {"predict_s", median(values_of(scores, &Score::predict_s))}};
  return {{"field", result.c.field},     {"layout", result.c.layout},
          {"count", result.c.count},     {"coverage_95", result.coverage},
          {"rejected", result.rejected}, {"methods", std::move(methods)}};
}

/// Prints medians over every case, and their ratios to those of the automatic choice.
void print_times(const std::vector<CaseResult>& results) {
  std::map<std::string, std::vector<double>> fit;
  std::map<std::string, std::vector<double>> predict;
  for (const CaseResult& result : results) {
    for (const auto& [method, scores] : result.scores) {
      for (const Score& score : scores) {
        fit[method].push_back(score.fit_s);
        predict[method].push_back(score.predict_s);
      }
    }
  }
  fmt::print("\n{:24} {:>10} {:>8} {:>12} {:>8}\n", "medians of all", "fit ms", "/ auto",
             "predict us", "/ auto");
  for (const auto& [method, seconds] : fit)
    fmt::print("{:24} {:10.2f} {:8.3f} {:12.2f} {:8.3f}\n", method, 1e3 * median(seconds),
               median(seconds) / median(fit["auto"]), 1e6 * median(predict[method]),
               median(predict[method]) / median(predict["auto"]));
}

void run_all(const Options& options) {
  require_scipy();
  std::vector<CaseResult> results;
  nlohmann::json json = nlohmann::json::array();
  for (const std::string& layout : options.layouts) {
    for (const std::string& field : options.fields) {
      results.push_back(run({field, layout, options.count}, options.draws, options.first_seed));
      print_case(results.back());
      json.push_back(figures(results.back()));
    }
  }
  print_times(results);
  if (!options.json.empty()) std::ofstream(options.json) << json.dump(2) << '\n';
}

}  // namespace
}  // namespace planar::bench

int main(int argc, char** argv) {
  planar::bench::Options options;
  CLI::App app("Error maps of this project and of other libraries on made-up fields");
  app.add_option("--fields", options.fields, "f1 ... f5")->delimiter(',');
  app.add_option("--layouts", options.layouts, "rings, random, grid")->delimiter(',');
  app.add_option("--count", options.count, "pairs")->capture_default_str();
  app.add_option("--draws", options.draws, "noise draws of each case")->capture_default_str();
  app.add_option("--first-seed", options.first_seed, "of the draws")->capture_default_str();
  app.add_option("--json", options.json, "file for all figures");
  CLI11_PARSE(app, argc, argv);
  try {
    planar::bench::run_all(options);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}
