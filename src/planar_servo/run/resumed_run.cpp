#include "planar_servo/run/resumed_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/core/error.h"
#include "planar_servo/core/fixed.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/growing_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Results are written to the nanometre.
constexpr double kSamePlace_m = 1e-9;

/// Throws unless a run that was begun with these files was begun with the present ones, too. One
/// that does not say what it was begun with is gone on with.
void require_same_origins(const fs::path& results, const std::vector<Origin>& present) {
  const std::vector<Origin> begun = read_origins(results);
  const auto same = [](const Origin& a, const Origin& b) {
    return a.role == b.role && a.sha256 == b.sha256;
  };
  if (begun.empty() || std::equal(begun.begin(), begun.end(), present.begin(), present.end(), same))
    return;
  const auto names = [](const std::vector<Origin>& origins) {
    std::vector<std::string> texts;
    texts.reserve(origins.size());
    for (const Origin& origin : origins)
      texts.push_back(fmt::format("{} {}", origin.name, origin.sha256.substr(0, 8)));
    return fmt::format("{}", fmt::join(texts, ", "));
  };
  throw InputError(
      fmt::format("{}: the run was begun with {}; now it would go on with {}; use the same files "
                  "and options, or name another folder",
                  results.string(), names(begun), names(present)));
}

}  // namespace

fs::path results_file(const ServoRequest& request) {
  return request.out / "results.csv";
}

std::vector<Origin> run_origins(const ServoRequest& request) {
  std::vector<Origin> origins;
  for (const MadeFile& file : calibration_files(request.cell, request.use_error_map))
    origins.push_back(origin_of(file));
  if (request.cell.arm_found)
    origins.push_back(origin_of({Role::kArmFound, *request.cell.arm_found}));
  return origins;
}

const fs::path& folder_for(const ServoRequest& request) {
  if (request.resume && !fs::exists(results_file(request)))
    throw InputError(request.out.string() +
                     ": holds no run to go on with; name the folder of one, or leave out --resume "
                     "to begin one there");
  // A run would put its own report in the place of the path's.
  const fs::path looks = request.out / "path_looks.csv";
  if (fs::exists(looks))
    throw InputError(looks.string() + ": the folder holds the run of a path; name another folder");
  make_folder(request.out);
  require_writable(request.out / "run.yaml", "run");
  require_writable(request.out / "report.html", "page");
  return request.out;
}

std::vector<TargetResult> results_so_far(const ServoRequest& request) {
  const fs::path results = results_file(request);
  if (!fs::exists(results)) return {};
  if (!request.resume)
    throw InputError(results.string() +
                     ": holds a run already; name another folder or add --resume");
  drop_torn_line(results, results_header());
  require_same_origins(results, run_origins(request));
  return read_results(results);
}

void require_same_place(const TargetRow& target, const std::vector<TargetResult>& results) {
  for (const TargetResult& result : results)
    if (result.id == target.id && (result.p_d - target.p_d).norm() > kSamePlace_m)
      throw InputError(fmt::format(
          "target '{}' is at {} now; the run to go on with has a result of it at {}; name another "
          "folder, or another id for the new place",
          target.id, place_mm(target.p_d), place_mm(result.p_d)));
}

}  // namespace planar
