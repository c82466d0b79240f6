#include "planar_servo/offline/map/map_check_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

std::string row_text(const char* name, const Summary& summary) {
  return fmt::format("{:<20}{:<10.4f}{:<10.4f}{:<10.4f}{:.4f}\n", name, summary.mean / kMillimetre,
                     summary.rms / kMillimetre, summary.p95 / kMillimetre,
                     summary.max / kMillimetre);
}

}  // namespace

std::string map_check_text(const MapCheck& check, std::size_t n_left_out) {
  std::string text;
  if (n_left_out > 0)
    text += fmt::format("left out            {} pairs of other plans\n", n_left_out);
  text += fmt::format("pairs               {} ({} outside the map's valid region)\n", check.raw.n,
                      check.n_outside);
  text += fmt::format("{:<20}{:<10}{:<10}{:<10}{:<10}mm\n", "", "mean", "rms", "95 %", "max");
  text += row_text("vision error", check.raw) + row_text("with the map", check.compensated);
  text += fmt::format("accuracy            A1 {:.1f} %, A2 {:.1f} %\n", 100.0 * check.a1,
                      100.0 * check.a2);
  if (std::isfinite(check.coverage_95))
    text += fmt::format("within 95 %         {:.1f} %\n", 100.0 * check.coverage_95);
  return text;
}

nlohmann::json map_check_json(const MapCheck& check) {
  return {{"n", check.raw.n},
          {"n_outside", check.n_outside},
          {"raw_mean_mm", check.raw.mean / kMillimetre},
          {"raw_rms_mm", check.raw.rms / kMillimetre},
          {"mean_mm", check.compensated.mean / kMillimetre},
          {"rms_mm", check.compensated.rms / kMillimetre},
          {"p95_mm", check.compensated.p95 / kMillimetre},
          {"max_mm", check.compensated.max / kMillimetre},
          {"a1", check.a1},
          {"a2", check.a2},
          {"coverage_95", check.coverage_95}};
}

}  // namespace planar
