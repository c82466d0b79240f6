#include "scipy_peer.h"

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "support/error_fields.h"

namespace planar::bench {
namespace {

void write(const std::vector<ErrorSample>& samples, const std::filesystem::path& path) {
  std::ofstream file(path);
  for (const ErrorSample& sample : samples) {
    const Eigen::Vector2d p_mm = sample.p_vision / kMillimetre;
    const Eigen::Vector2d error_mm = sample.error / kMillimetre;
    file << fmt::format("{},{},{},{}\n", p_mm.x(), p_mm.y(), error_mm.x(), error_mm.y());
  }
}

std::string output_of(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) throw WorkError("cannot run " + command, Cause::kSystem);
  std::string output;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    output.append(buffer.data(), n);
  if (pclose(pipe) != 0) throw WorkError(command + " failed", Cause::kSystem);
  return output;
}

}  // namespace

void require_scipy() {
  const std::string probe = BENCH_PYTHON " -c 'import numpy, scipy' 2>/dev/null";
  if (std::system(probe.c_str()) != 0)
    throw WorkError(BENCH_PYTHON " cannot import numpy and scipy; bench/install makes it anew",
                    Cause::kMissing);
}

std::map<std::string, std::vector<Score>> run_scipy(
    const std::vector<std::vector<ErrorSample>>& draws, const std::vector<ErrorSample>& truth,
    const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  write(truth, folder / "truth.csv");
  for (std::size_t i = 0; i < draws.size(); ++i)
    write(draws[i], folder / fmt::format("draw_{:03}.csv", i));
  const auto found = nlohmann::json::parse(output_of(fmt::format(
      "OPENBLAS_NUM_THREADS=1 '{}' '{}' '{}'", BENCH_PYTHON, SCIPY_PEER, folder.string())));
  std::filesystem::remove_all(folder);
  std::map<std::string, std::vector<Score>> scores;
  for (const auto& [kernel, runs] : found.items()) {
    for (const auto& run : runs) {
      const double error = run["error_mm"].get<double>() * kMillimetre;
      scores["scipy " + kernel].push_back(
          {error / test::kFieldNoise, run["fit_s"].get<double>(), run["predict_s"].get<double>()});
    }
  }
  return scores;
}

}  // namespace planar::bench
