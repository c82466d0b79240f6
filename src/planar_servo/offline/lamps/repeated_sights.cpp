#include "planar_servo/offline/lamps/repeated_sights.h"

#include <cmath>
#include <map>
#include <string>

namespace planar {

std::vector<RepeatedSight> repeated_sights(const std::vector<LampRow>& rows) {
  std::map<std::string, std::vector<std::size_t>> places;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].status == LampStatus::kOk) places[rows[i].id].push_back(i);
  std::vector<RepeatedSight> sights;
  for (const auto& [id, images] : places) {
    const auto n = static_cast<double>(images.size());
    if (images.size() < 2) continue;
    for (std::size_t lamp = 0; lamp < rows[images.front()].uv_px.size(); ++lamp) {
      Eigen::Vector2d mean(0.0, 0.0);
      for (const std::size_t i : images) mean += rows[i].uv_px[lamp] / n;
      for (const std::size_t i : images) {
        const Eigen::Vector2d off = std::sqrt(n / (n - 1.0)) * (rows[i].uv_px[lamp] - mean);
        const Eigen::Vector2d sigma = rows[i].covariance_px2[lamp].diagonal().cwiseSqrt();
        sights.push_back({static_cast<double>(i + 1), off, off.cwiseQuotient(sigma)});
      }
    }
  }
  return sights;
}

}  // namespace planar
