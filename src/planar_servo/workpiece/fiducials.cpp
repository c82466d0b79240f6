#include "planar_servo/workpiece/fiducials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lamps/lamp_center.h"

namespace planar {
namespace {

using Contour = std::vector<cv::Point>;

/// The share by which a candidate's size may differ from the expected one: perspective over the
/// field, and an outline that is found at another level than the middle.
constexpr double kSizeShare = 0.35;
/// By how much a mark differs from the mean of its surroundings. The mean takes in a tenth of the
/// mark itself.
constexpr double kLeastStep = 0.5 * kLeastContrast;

/// A connected part that is brighter or darker than its surroundings, with what lies in its holes.
struct Part {
  Contour outline;
  double area_px2{0.0};       ///< within the outline
  double hull_area_px2{0.0};  ///< of the convex hull
  double holes_px2{0.0};
  double extent_px{0.0};  ///< diameter of the smallest circle around it
  Eigen::Vector2d centroid_px{0.0, 0.0};
};

/// Returns what is brighter, or darker, than the mean of a wide window.
cv::Mat unlike_mean(const cv::Mat& image, bool bright, double size_px) {
  const int window = 2 * static_cast<int>(std::ceil(1.5 * size_px)) + 3;
  cv::Mat mask;
  cv::adaptiveThreshold(image, mask, 255, cv::ADAPTIVE_THRESH_MEAN_C,
                        bright ? cv::THRESH_BINARY : cv::THRESH_BINARY_INV, window,
                        bright ? -kLeastStep : kLeastStep);
  return mask;
}

/// Returns what is brighter than its surroundings and too narrow for a square, which does not fit
/// into a disc of 1.1 times the size, and well into the corner of a plate. (Near its edge a plate
/// is brighter than the mean there, so that a bright disc would be one part with it.)
cv::Mat bright_and_narrow(const cv::Mat& image, double size_px) {
  const int side = static_cast<int>(std::ceil(0.8 * size_px)) + 3;
  cv::Mat hat;
  cv::morphologyEx(image, hat, cv::MORPH_TOPHAT, cv::Mat::ones(side, side, CV_8U));
  return hat > 2.0 * kLeastStep;
}

Part part_of(Contour outline, double holes_px2) {
  Part part;
  Contour hull;
  cv::convexHull(outline, hull);
  cv::Point2f center;
  float radius = 0.0F;
  cv::minEnclosingCircle(outline, center, radius);
  const cv::Moments moments = cv::moments(outline);
  part.area_px2 = moments.m00;
  part.hull_area_px2 = cv::contourArea(hull);
  part.holes_px2 = holes_px2;
  part.extent_px = 2.0 * radius;
  part.centroid_px = {moments.m10 / moments.m00, moments.m01 / moments.m00};
  part.outline = std::move(outline);
  return part;
}

/// Returns the parts of a kind's brightness whose boxes are about so large.
std::vector<Part> parts_in(const cv::Mat& image, FiducialKind kind, bool bright, double size_px) {
  cv::Mat smooth;
  cv::blur(image, smooth, {3, 3});
  std::vector<Contour> contours;
  std::vector<cv::Vec4i> tree;  // next, previous, first child, parent
  cv::findContours(kind == FiducialKind::kBrightDisc ? bright_and_narrow(smooth, size_px)
                                                     : unlike_mean(smooth, bright, size_px),
                   contours, tree, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  std::vector<Part> parts;
  for (std::size_t i = 0; i < contours.size(); ++i) {
    const cv::Rect box = cv::boundingRect(contours[i]);
    const auto [least, most] = std::minmax(box.width, box.height);
    if (tree[i][3] >= 0 || most > 1.5 * size_px + 3.0 || least < 0.4 * size_px - 2.0) continue;
    double holes = 0.0;
    for (int hole = tree[i][2]; hole >= 0; hole = tree[static_cast<std::size_t>(hole)][0])
      holes += cv::contourArea(contours[static_cast<std::size_t>(hole)]);
    if (cv::contourArea(contours[i]) < 4.0) continue;
    parts.push_back(part_of(std::move(contours[i]), holes));
  }
  return parts;
}

bool has_size(double size_px, double expected_px) {
  return std::abs(size_px - expected_px) < kSizeShare * expected_px + 2.0;
}

double round_size_px(const Part& part) {
  return 2.0 * std::sqrt(part.area_px2 / kPi);
}

/// Returns whether the part looks like this kind, whatever its size.
bool has_form(const Part& part, FiducialKind kind) {
  constexpr double kLeastFill = 0.9;      // of a disc in its hull, whose pixels are coarse
  constexpr double kLeastHole = 0.06;     // share of a ring's area within its outline
  constexpr double kLeastRound = 0.72;    // area by that of the circle around it; a square has 0.64
  constexpr double kMostCrossFill = 0.8;  // of a cross in its hull: arms of a third have 0.71
  const double fill = part.area_px2 / part.hull_area_px2;
  const double hole = part.holes_px2 / part.area_px2;
  const double roundness = part.area_px2 / (0.25 * kPi * part.extent_px * part.extent_px);
  if (kind == FiducialKind::kCross) return fill < kMostCrossFill && hole < kLeastHole;
  if (fill < kLeastFill || roundness < kLeastRound) return false;
  return (kind == FiducialKind::kRing) == (hole > kLeastHole);
}

/// Returns whether the levels step down, or up, across the outline of a round part. The
/// surroundings of a dark disc are brighter than the mean there, too, but end in nothing.
bool has_edge(const cv::Mat& image, const Part& part, bool bright) {
  const double reach_px = std::max(2.0, 0.06 * part.extent_px);
  const cv::Rect whole({}, image.size());
  double step = 0.0;
  for (const cv::Point& point : part.outline) {
    const Eigen::Vector2d out = Eigen::Vector2d(point.x, point.y) - part.centroid_px;
    const auto at = [&](double px) {
      const Eigen::Vector2d place = part.centroid_px + out * (1.0 + px / std::max(1.0, out.norm()));
      return cv::Point(static_cast<int>(std::lround(place.x())),
                       static_cast<int>(std::lround(place.y())));
    };
    const cv::Point inner = at(-reach_px), outer = at(reach_px);
    if (!whole.contains(inner) || !whole.contains(outer)) return false;
    step += image.at<std::uint8_t>(inner) - image.at<std::uint8_t>(outer);
  }
  return (bright ? step : -step) > kLeastStep * static_cast<double>(part.outline.size());
}

bool looks_like(const cv::Mat& image, const Part& part, FiducialKind kind, bool bright) {
  return has_form(part, kind) && (kind == FiducialKind::kCross || has_edge(image, part, bright));
}

std::vector<FiducialSight> find_parts(const cv::Mat& image, FiducialKind kind, double size_px) {
  std::vector<FiducialSight> found;
  for (const bool bright : {true, false}) {
    if (kind == (bright ? FiducialKind::kDarkDisc : FiducialKind::kBrightDisc)) continue;
    for (const Part& part : parts_in(image, kind, bright, size_px)) {
      const double size = kind == FiducialKind::kCross ? part.extent_px : round_size_px(part);
      if (has_size(size, size_px) && looks_like(image, part, kind, bright))
        found.push_back({part.centroid_px, Eigen::Matrix2d::Zero(), size, -1});
    }
  }
  return found;
}

/// Returns the determinant of the grey levels' second derivatives with its sign changed, which is
/// large at saddles.
cv::Mat1f saddles(const cv::Mat& image, double blur_px) {
  cv::Mat1f smooth, xx, yy, xy;
  image.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {}, blur_px);
  cv::Sobel(smooth, xx, CV_32F, 2, 0, 3, 0.25);
  cv::Sobel(smooth, yy, CV_32F, 0, 2, 3, 0.25);
  cv::Sobel(smooth, xy, CV_32F, 1, 1, 3, 0.25);
  cv::multiply(xy, xy, xy);
  cv::multiply(xx, yy, xx);
  cv::subtract(xy, xx, xy);
  return xy;
}

/// Returns whether the levels on a circle change twice from bright to dark, evenly.
bool has_four_quarters(const cv::Mat& image, const cv::Point& center, double radius_px) {
  constexpr int kSamples = 32;
  std::array<double, kSamples> levels{};
  double mean = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double angle = 2.0 * kPi * i / kSamples;
    const cv::Point at(static_cast<int>(std::lround(center.x + radius_px * std::cos(angle))),
                       static_cast<int>(std::lround(center.y + radius_px * std::sin(angle))));
    if (!cv::Rect({}, image.size()).contains(at)) return false;
    levels[static_cast<std::size_t>(i)] = image.at<std::uint8_t>(at);
    mean += levels[static_cast<std::size_t>(i)] / kSamples;
  }
  double cosine = 0.0, sine = 0.0, power = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double level = levels[static_cast<std::size_t>(i)] - mean;
    const double angle = 4.0 * kPi * i / kSamples;
    cosine += level * std::cos(angle);
    sine += level * std::sin(angle);
    power += level * level;
  }
  const double wave = (cosine * cosine + sine * sine) * 2.0 / kSamples;  // its share of the power
  // A square wave has 81 % of its power in its first wave.
  return power > kSamples * kLeastStep * kLeastStep && wave > 0.65 * power;
}

std::vector<FiducialSight> find_chess_corners(const cv::Mat& image, double size_px) {
  constexpr int kBandRows = 512;  // bounds the memory of the derivatives
  const double blur_px = std::max(1.0, size_px / 12.0);
  const int reach = static_cast<int>(std::ceil(0.5 * size_px + 4.0 * blur_px)) + 2;
  const double least = std::pow(0.1 * kLeastContrast / (blur_px * blur_px), 2);
  std::vector<FiducialSight> found;
  for (int begin = 0; begin < image.rows; begin += kBandRows) {
    const int from = std::max(0, begin - reach),
              to = std::min(image.rows, begin + kBandRows + reach);
    const cv::Mat1f response = saddles(image.rowRange(from, to), blur_px);
    cv::Mat1f greatest;
    cv::dilate(response, greatest, cv::Mat::ones(reach, reach, CV_8U));
    for (int row = begin; row < std::min(image.rows, begin + kBandRows); ++row)
      for (int column = 0; column < image.cols; ++column) {
        const float value = response(row - from, column);
        if (value < least || value < greatest(row - from, column)) continue;
        if (has_four_quarters(image, {column, row}, 0.25 * size_px))
          found.push_back({{column, row}, Eigen::Matrix2d::Zero(), size_px, -1});
      }
  }
  return found;
}

FiducialSight tag_sight(int number, const std::vector<cv::Point2f>& corners) {
  const auto at = [&](std::size_t i) { return Eigen::Vector2d(corners[i].x, corners[i].y); };
  // The diagonals of a square meet in its centre's image.
  const Eigen::Vector2d first = at(2) - at(0), second = at(3) - at(1);
  const double along = cross2d(at(1) - at(0), second) / cross2d(first, second);
  return {at(0) + along * first, Eigen::Matrix2d::Zero(),
          0.25 * ((at(1) - at(0)).norm() + (at(2) - at(1)).norm() + (at(3) - at(2)).norm() +
                  (at(0) - at(3)).norm()),
          number};
}

std::vector<FiducialSight> find_tags(const cv::Mat& image, double size_px) {
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  parameters->minMarkerPerimeterRate =
      std::min(0.03, 4.0 * (1.0 - kSizeShare) * size_px / std::max(image.cols, image.rows));
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> numbers;
  cv::aruco::detectMarkers(image,
                           cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11),
                           corners, numbers, parameters);
  std::vector<FiducialSight> found;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const FiducialSight tag = tag_sight(numbers[i], corners[i]);
    if (has_size(tag.size_px, size_px)) found.push_back(tag);
  }
  return found;
}

/// A part of the image around a mark.
struct Crop {
  cv::Mat image;  ///< of its own memory
  Eigen::Vector2d corner_px;
};

std::optional<Crop> crop_round(const cv::Mat& image, const FiducialSight& found, double sizes) {
  const double half = sizes * found.size_px + 8.0;
  const cv::Rect box = window_round(found.uv_px, half) & cv::Rect({}, image.size());
  if (box.width < 8 || box.height < 8) return std::nullopt;
  return Crop{image(box).clone(), {box.x, box.y}};
}

/// Returns the part of a mark in the middle of a crop; a ring of either brightness.
std::optional<std::pair<Part, bool>> middle_part(const Crop& crop, FiducialKind kind,
                                                 const FiducialSight& found) {
  for (const bool bright : {true, false}) {
    if (kind == (bright ? FiducialKind::kDarkDisc : FiducialKind::kBrightDisc)) continue;
    for (Part& part : parts_in(crop.image, kind, bright, found.size_px))
      if (has_size(round_size_px(part), found.size_px) &&
          looks_like(crop.image, part, kind, bright) &&
          (part.centroid_px + crop.corner_px - found.uv_px).norm() < 0.5 * found.size_px)
        return std::make_pair(std::move(part), bright);
  }
  return std::nullopt;
}

/// Returns how far the pixels within a part's outline, or outside it, are from it; 0 on the other
/// side.
cv::Mat1f distances(const cv::Size& size, const Part& part, bool within) {
  cv::Mat side(size, CV_8U, cv::Scalar(within ? 0 : 255));
  cv::drawContours(side, std::vector<Contour>{part.outline}, 0, cv::Scalar(within ? 255 : 0),
                   cv::FILLED);
  cv::Mat1f distance;
  cv::distanceTransform(side, distance, cv::DIST_L2, 3);
  return distance;
}

/// Returns the median level of the pixels between two distances.
int median_between(const cv::Mat& image, const cv::Mat1f& distance, double from, double to) {
  LevelHistogram levels;
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.cols; ++column)
      if (const float px = distance(row, column); px > from && px < to)
        levels.add(image.at<std::uint8_t>(row, column));
  return levels.median();
}

/// Fills what a ring encloses with the ring's own level, so that its outer rim is that of a disc.
void fill_ring(cv::Mat& image, const Part& part) {
  const double middle_px =
      0.25 * std::sqrt(4.0 / kPi) * (std::sqrt(part.area_px2) - std::sqrt(part.holes_px2));
  const cv::Mat1f distance = distances(image.size(), part, true);
  image.setTo(median_between(image, distance, middle_px - 1.0, middle_px + 1.0),
              distance > middle_px);
}

int otsu_level(const cv::Mat& image) {
  LevelHistogram levels;
  for (int row = 0; row < image.rows; ++row)
    levels.add(image.ptr(row), image.ptr(row) + image.cols);
  return levels.otsu();
}

/// Returns the level at which a bright part leaves its surroundings. Where a plate that is brighter
/// than what is around it ends near the part, all beyond gets the level of the plate.
int level_against_surroundings(cv::Mat& image, const Part& part) {
  const int level = otsu_level(image);
  const cv::Mat1f distance = distances(image.size(), part, false);
  const double near_px = std::max(3.0, 0.06 * part.extent_px), far_px = 2.0 * near_px;
  const int around = median_between(image, distance, near_px, far_px);
  if (around < level) return level;
  image.setTo(around, distance > far_px);
  return otsu_level(image);
}

std::optional<FiducialSight> measure_round(const cv::Mat& image, FiducialKind kind,
                                           const FiducialSight& found) {
  std::optional<Crop> crop = crop_round(image, found, 1.5);
  if (!crop) return std::nullopt;
  const auto part = middle_part(*crop, kind, found);
  if (!part) return std::nullopt;
  if (!part->second) cv::bitwise_not(crop->image, crop->image);
  if (kind == FiducialKind::kRing) fill_ring(crop->image, part->first);
  const cv::Rect box = cv::boundingRect(part->first.outline);
  const int level = level_against_surroundings(crop->image, part->first);
  const Blob blob = describe_blob(crop->image, box, level);
  const LampCenter measured = measure_lamp(crop->image, blob, CenterMethod::kAuto);
  if (measured.status != LampStatus::kOk) return std::nullopt;
  return FiducialSight{measured.uv_px + crop->corner_px, measured.covariance_px2,
                       measured.diameter_px, -1};
}

std::optional<FiducialSight> measure_corner(const cv::Mat& image, const FiducialSight& found,
                                            double reach) {
  const std::optional<Crop> crop = crop_round(image, found, 1.0);
  if (!crop) return std::nullopt;
  const int half = std::max(3, static_cast<int>(std::lround(reach * found.size_px)));
  const Eigen::Vector2d start = found.uv_px - crop->corner_px;
  std::vector<cv::Point2f> corner{{static_cast<float>(start.x()), static_cast<float>(start.y())}};
  if (2 * half + 5 > std::min(crop->image.cols, crop->image.rows)) return std::nullopt;
  cv::cornerSubPix(crop->image, corner, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-4});
  const Eigen::Vector2d uv_px = Eigen::Vector2d(corner[0].x, corner[0].y) + crop->corner_px;
  if ((uv_px - found.uv_px).norm() > 0.25 * found.size_px) return std::nullopt;
  return FiducialSight{uv_px, Eigen::Matrix2d::Zero(), found.size_px, -1};
}

std::optional<FiducialSight> measure_tag(const cv::Mat& image, const FiducialSight& found) {
  const std::optional<Crop> crop = crop_round(image, found, 1.5);
  if (!crop) return std::nullopt;
  for (FiducialSight& tag : find_tags(crop->image, found.size_px))
    if (tag.tag == found.tag) {
      tag.uv_px += crop->corner_px;
      return tag;
    }
  return std::nullopt;
}

}  // namespace

bool is_round(FiducialKind kind) {
  return kind == FiducialKind::kBrightDisc || kind == FiducialKind::kDarkDisc ||
         kind == FiducialKind::kRing;
}

std::optional<int> tag_number(const std::string& id) {
  const std::size_t last = id.find_last_not_of("0123456789");
  const std::string digits = id.substr(last == std::string::npos ? 0 : last + 1);
  if (digits.empty() || digits.size() > 4) return std::nullopt;
  return std::stoi(digits);
}

bool may_have_tag(const Fiducial& mark, std::optional<int> tag) {
  return mark.kind != FiducialKind::kAprilTag || tag_number(mark.id) == tag;
}

std::vector<FiducialSight> find_fiducials(const cv::Mat& image, FiducialKind kind, double size_px) {
  require_8_bit(image);
  if (kind == FiducialKind::kChessCorner) return find_chess_corners(image, size_px);
  if (kind == FiducialKind::kAprilTag) return find_tags(image, size_px);
  return find_parts(image, kind, size_px);
}

std::optional<FiducialSight> measure_fiducial(const cv::Mat& image, FiducialKind kind,
                                              const FiducialSight& found) {
  if (kind == FiducialKind::kAprilTag) return measure_tag(image, found);
  if (kind == FiducialKind::kChessCorner) return measure_corner(image, found, 0.3);
  if (kind == FiducialKind::kCross) return measure_corner(image, found, 0.4);
  return measure_round(image, kind, found);
}

}  // namespace planar
