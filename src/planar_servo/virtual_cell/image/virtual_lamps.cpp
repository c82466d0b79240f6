#include "planar_servo/virtual_cell/image/virtual_lamps.h"

#include <algorithm>

namespace planar {

VirtualLamps::VirtualLamps(const Truth& truth)
    : lamps_(truth.lamps),
      places_m_(truth.tool.lamps_m),
      fixed_(truth.reference_lamps),
      blur_px_(truth.camera.blur_px) {}

std::optional<Light> VirtualLamps::render(const Pose& X_BT, const VirtualLens& lens,
                                          double t_s) const {
  const std::vector<SeenLamp> seen = see_tool(X_BT, lens, t_s);
  if (seen.empty()) return std::nullopt;
  return light_of(seen, blur_px_);
}

std::vector<Light> VirtualLamps::render_all(const Pose& X_BT, const VirtualLens& lens,
                                            double t_s) const {
  std::vector<std::vector<SeenLamp>> groups;
  if (std::vector<SeenLamp> tool = see_tool(X_BT, lens, t_s); !tool.empty())
    groups.push_back(std::move(tool));
  for (const ReferenceLampTruth& fixed : fixed_) {
    Pose X_BF = Pose::Identity();
    X_BF.translation() = fixed.p_B;
    auto seen = see_lamp(fixed.lamp, Eigen::Vector2d::Zero(), X_BF, lens, t_s);
    if (!seen) continue;
    const auto near = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
      return !(light_window(group, blur_px_) & light_window({*seen}, blur_px_)).empty();
    });
    if (near == groups.end())
      groups.push_back({std::move(*seen)});
    else
      near->push_back(std::move(*seen));
  }
  std::vector<Light> lights;
  lights.reserve(groups.size());
  for (const auto& group : groups) lights.push_back(light_of(group, blur_px_));
  return lights;
}

std::vector<SeenLamp> VirtualLamps::see_tool(const Pose& X_BT, const VirtualLens& lens,
                                             double t_s) const {
  std::vector<SeenLamp> lamps;
  for (std::size_t i = 0; i < lamps_.size(); ++i)
    if (auto seen = see_lamp(lamps_[i], places_m_[i], X_BT, lens, t_s))
      lamps.push_back(std::move(*seen));
  return lamps;
}

}  // namespace planar
