#include "planar_servo/work/workpiece/bar_places.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/offline/grey_image.h"
#include "planar_servo/work/workpiece/work_watch.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Returns how far the ends of a bar move from one stance to another, at least.
double distance(const BarStance& a, const BarStance& b, double length) {
  const double turn = std::abs(std::remainder(a.turn - b.turn, kPi));
  return std::hypot((a.middle_B - b.middle_B).norm(), 0.5 * length * turn);
}

std::string words_of(const BarStance& stance) {
  return fmt::format("its middle near {}, turned by {:.0f} deg", place_mm(stance.middle_B),
                     stance.turn / kDegree);
}

std::vector<BarStance> stances_in(const Frame& frame, const std::vector<Fiducial>& bar,
                                  const VisionCalibration& vision) {
  std::vector<BarStance> stances;
  for (const BarSight& seen : see_bars({frame}, vision, bar)) {
    const Eigen::Vector2d along = seen.p_B[1] - seen.p_B[0];
    stances.push_back({0.5 * (seen.p_B[0] + seen.p_B[1]), std::atan2(along.y(), along.x())});
  }
  return stances;
}

/// Returns the stances in pictures that were taken before; those without a bar have none.
std::vector<BarStance> stances_so_far(const fs::path& folder, const std::vector<Fiducial>& bar,
                                      const VisionCalibration& vision) {
  std::vector<BarStance> taken;
  for (const fs::path& picture : bar_pictures(folder)) {
    const cv::Mat image = read_grey_image(picture);
    if (image.empty()) continue;
    try {
      const auto stances = stances_in({image, {{}, image.size()}}, bar, vision);
      taken.insert(taken.end(), stances.begin(), stances.end());
    } catch (const WorkError& error) {
      spdlog::warn(error.refusal().at(picture.string()).text());
    }
  }
  return taken;
}

/// Throws WorkError where every bar has its marks on where they lay before: it tells nothing new.
void require_elsewhere(const std::vector<BarStance>& now, const std::vector<BarStance>& taken,
                       const std::vector<Fiducial>& bar) {
  const double length = (bar[1].p_W - bar[0].p_W).norm();
  const auto is_known = [&](const BarStance& stance) {
    return std::any_of(taken.begin(), taken.end(), [&](const BarStance& other) {
      return distance(stance, other, length) < bar[0].size;
    });
  };
  if (std::all_of(now.begin(), now.end(), is_known))
    throw WorkError({"the bar lies where it lay before, " + words_of(now.front()),
                     "lay it elsewhere", "", Cause::kInsufficient});
}

}  // namespace

std::vector<BarStance> bar_stances(double radius, double length, std::size_t count) {
  const double room = std::sqrt(std::max(0.0, radius * radius - 0.25 * length * length));
  constexpr double kShares[] = {0.0, 0.7, -0.7};
  std::vector<BarStance> stances;
  for (std::size_t i = 0; i < count; ++i) {
    const double turn = kPi * static_cast<double>(i) / static_cast<double>(count);
    const double aside = kShares[i % std::size(kShares)] * room;
    stances.push_back({aside * Eigen::Vector2d(-std::sin(turn), std::cos(turn)), turn});
  }
  return stances;
}

BarStance next_stance(const std::vector<BarStance>& wanted, const std::vector<BarStance>& taken,
                      double length) {
  const auto nearest = [&](const BarStance& stance) {
    double least = std::numeric_limits<double>::infinity();
    for (const BarStance& other : taken) least = std::min(least, distance(stance, other, length));
    return least;
  };
  return *std::max_element(
      wanted.begin(), wanted.end(),
      [&](const BarStance& a, const BarStance& b) { return nearest(a) < nearest(b); });
}

std::vector<fs::path> bar_pictures(const fs::path& folder) {
  std::vector<fs::path> pictures;
  if (!fs::exists(folder)) return pictures;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".png" && entry.path().stem().string().rfind("bar_", 0) == 0)
      pictures.push_back(entry.path());
  std::sort(pictures.begin(), pictures.end());
  return pictures;
}

std::vector<fs::path> record_bar(const std::vector<Fiducial>& bar, const VisionCalibration& vision,
                                 const Workspace& workspace, std::size_t wanted,
                                 const fs::path& folder, FrameSource& camera, Operator& person,
                                 const std::function<bool()>& stop) {
  const double length = (bar[1].p_W - bar[0].p_W).norm();
  const std::vector<BarStance> stances = bar_stances(workspace.radius_max_m, length, wanted);
  std::vector<BarStance> taken = stances_so_far(folder, bar, vision);
  std::size_t there = bar_pictures(folder).size(), number = 0;
  const auto picture = [&] { return folder / fmt::format("bar_{:02}.png", number); };
  while (there < wanted && !stop()) {
    const std::string question = fmt::format(
        "{} of {} pictures of the bar; lay it with {}, then Enter, or end with q: ", there, wanted,
        words_of(next_stance(stances, taken, length)));
    if (person.is_attended() && person.ask(question) == "q") break;
    try {
      const Frame frame = whole_frames(camera, 1, std::nullopt).front();
      const std::vector<BarStance> stances_now = stances_in(frame, bar, vision);
      require_elsewhere(stances_now, taken, bar);
      for (const BarStance& stance : stances_now) {
        taken.push_back(stance);
        person.say("the bar is seen with " + words_of(stance));
      }
      while (fs::exists(picture())) ++number;
      write_picture(picture(), frame.image);
      ++there;
    } catch (const WorkError& error) {
      if (!person.is_attended()) throw;
      person.warn(error.what());
    }
    if (!person.is_attended()) break;
  }
  return bar_pictures(folder);
}

}  // namespace planar
