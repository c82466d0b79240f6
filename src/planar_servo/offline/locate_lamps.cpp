#include "planar_servo/offline/locate_lamps.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/lamps/lamp_tracker.h"

namespace planar {

namespace {

/// The most whole frames in which a light must be seen to stand still.
constexpr std::size_t kStillFrames = 12;
/// The most lights of a whole frame that are considered.
constexpr std::size_t kMostLights = 64;

/// Returns the images of the whole sensor that may show the lamps, by time.
std::vector<const LampImage*> whole_frames(const std::vector<LampImage>& images,
                                           const cv::Size& sensor_px) {
  std::vector<const LampImage*> whole;
  for (const LampImage& image : images)
    if (!image.shows_board && image.t_s && image.region_px && image.region_px->size() == sensor_px)
      whole.push_back(&image);
  std::stable_sort(whole.begin(), whole.end(),
                   [](const LampImage* a, const LampImage* b) { return *a->t_s < *b->t_s; });
  return whole;
}

/// Holds an image that was read, or says why it was not.
struct LampImageRead {
  LampStatus status{LampStatus::kOk};  ///< or kBoardView, kUnreadable, kWrongSize
  Frame frame;                         ///< valid only when status is kOk
  std::string fault;                   ///< describes a wrong size in words
};

/// Reads an image as 8-bit grey levels. It must have the size of its region or, without one, that
/// of the sensor if that is known.
LampImageRead read_lamp_image(const LampImage& image, const std::optional<cv::Size>& sensor_px) {
  LampImageRead read;
  if (image.shows_board) {
    read.status = LampStatus::kBoardView;
    return read;
  }
  read.frame.image = image.set->read(image.file);
  if (read.frame.image.empty()) {
    read.status = LampStatus::kUnreadable;
    return read;
  }
  const cv::Size size = read.frame.image.size();
  read.frame.region_px = image.region_px.value_or(cv::Rect({0, 0}, size));
  read.frame.t_s = image.t_s.value_or(0.0);
  const cv::Size expected = image.region_px ? image.region_px->size() : sensor_px.value_or(size);
  if (size != expected) {
    read.status = LampStatus::kWrongSize;
    read.fault = fmt::format(
        "{}: is {} x {} pixels; {} says {} x {}", image.file.string(), size.width, size.height,
        image.region_px ? "frames.csv" : "the cell file", expected.width, expected.height);
  }
  return read;
}

Frame frame_of(const LampImage& image, const cv::Size& sensor_px) {
  LampImageRead read = read_lamp_image(image, sensor_px);
  if (read.status != LampStatus::kOk)
    throw WorkError(
        {name(read.status), "a whole frame is needed to find the reference lamps", image.file});
  return std::move(read.frame);
}

std::vector<LampCenter> lights_in(const cv::Mat& image, LampDetector& detector,
                                  CenterMethod method) {
  const std::vector<Blob>& blobs = detector.detect(image);
  std::vector<LampCenter> lights;
  for (std::size_t i = 0; i < std::min(blobs.size(), kMostLights); ++i) {
    const LampCenter light = measure_lamp(image, blobs[i], method);
    if (light.status == LampStatus::kOk) lights.push_back(light);
  }
  return lights;
}

/// Returns whether a light stands within half its diameter of where it stood.
bool stands(const LampCenter& light, const Frame& frame, LampDetector& detector,
            CenterMethod method) {
  const auto seen = find_fixed_light(frame, light.uv_px, detector, method);
  return seen && (seen->uv_px - light.uv_px).norm() < 0.5 * light.diameter_px;
}

/// Follows the lamps that are fixed to the base through the whole frames of a recording.
class ReferenceTrack {
 public:
  /// Nothing is watched; the image does not move.
  ReferenceTrack() = default;

  /// Looks at every whole frame in the order of time. Throws WorkError when the lamps disagree in
  /// one of them, because nothing recorded from there on can be trusted.
  ReferenceTrack(std::vector<ReferenceLamp> lamps, const std::vector<LampImage>& images,
                 const cv::Size& sensor_px, CenterMethod method)
      : lamps_(std::move(lamps)) {
    ReferenceWatch watch(lamps_, method);
    for (const LampImage* image : whole_frames(images, sensor_px)) {
      watch.look(frame_of(*image, sensor_px));
      if (watch.objection()) throw WorkError(watch.objection()->at(image->file));
      looks_.push_back({*image->t_s, watch.motion()});
    }
  }

  /// Returns how the image had moved at this time, from when the lamps were seen as lamps() says:
  /// between two looks in proportion to time, before the first and after the last as there.
  ImageMotion at(double t_s) const {
    if (looks_.empty()) return {};
    const auto next = std::find_if(looks_.begin(), looks_.end(),
                                   [&](const Look& look) { return look.t_s >= t_s; });
    if (next == looks_.end()) return looks_.back().motion;
    if (next == looks_.begin()) return next->motion;
    const Look& last = *(next - 1);
    return last.motion.towards(next->motion, (t_s - last.t_s) / (next->t_s - last.t_s));
  }

  const std::vector<ReferenceLamp>& lamps() const { return lamps_; }

 private:
  struct Look {
    double t_s;
    ImageMotion motion;
  };

  std::vector<ReferenceLamp> lamps_;
  std::vector<Look> looks_;
};

/// Finds the lights that stand still in the recording's whole frames and measures them in the first
/// of these: the reference for all others. Throws WorkError when fewer stand still than the cell
/// has lamps. Their ids are not known yet.
std::vector<ReferenceLamp> find_reference_lamps(const std::vector<ReferenceLampLayout>& layout,
                                                const std::vector<LampImage>& images,
                                                const cv::Size& sensor_px, CenterMethod method) {
  const std::vector<const LampImage*> whole = whole_frames(images, sensor_px);
  if (whole.size() < 2)
    throw WorkError(
        {fmt::format("{} whole frames show the lamps", whole.size()),
         fmt::format("at least 2 at different places are needed to tell the {} reference lamps of "
                     "the cell file from those of the tool: record with planar-record",
                     layout.size()),
         "", Cause::kInsufficient});
  LampDetector detector;
  std::vector<LampCenter> lights =
      lights_in(frame_of(*whole[0], sensor_px).image, detector, method);
  const std::size_t n = std::min(whole.size() - 1, kStillFrames);
  for (std::size_t i = 1; i <= n; ++i) {
    const Frame frame = frame_of(*whole[i * (whole.size() - 1) / n], sensor_px);
    lights.erase(std::remove_if(lights.begin(), lights.end(),
                                [&](const LampCenter& light) {
                                  return !stands(light, frame, detector, method);
                                }),
                 lights.end());
  }
  if (lights.size() < layout.size())
    throw WorkError(
        {fmt::format(
             "{} lights stand still in {} whole frames, but the cell file names {} reference lamps",
             lights.size(), n + 1, layout.size()),
         "uncover them, or name those that there are", "", Cause::kInsufficient});
  lights.resize(layout.size());
  return each(lights, [](const LampCenter& light) {
    return ReferenceLamp{"", light.uv_px, std::sqrt(0.5 * light.covariance_px2.trace())};
  });
}

/// Gives each lamp the id of the one that is stated where it is seen. Lamps of which a place is not
/// stated, or cannot be seen, are named in the order in which they are read in a book.
void name_reference_lamps(const std::vector<ReferenceLampLayout>& layout,
                          const std::optional<CoarseView>& view,
                          std::vector<ReferenceLamp>& lamps) {
  std::sort(lamps.begin(), lamps.end(), [](const ReferenceLamp& a, const ReferenceLamp& b) {
    return std::pair(a.uv_px.y(), a.uv_px.x()) < std::pair(b.uv_px.y(), b.uv_px.x());
  });
  std::vector<Eigen::Vector2d> stated;
  for (const ReferenceLampLayout& lamp : layout) {
    const auto place = lamp.p_B && view ? view->pixel(*lamp.p_B) : std::nullopt;
    if (place) stated.push_back(*place);
  }
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (stated.size() == layout.size())
      std::iter_swap(lamps.begin() + static_cast<std::ptrdiff_t>(i),
                     std::min_element(lamps.begin() + static_cast<std::ptrdiff_t>(i), lamps.end(),
                                      [&](const ReferenceLamp& a, const ReferenceLamp& b) {
                                        return (a.uv_px - stated[i]).squaredNorm() <
                                               (b.uv_px - stated[i]).squaredNorm();
                                      }));
    lamps[i].id = layout[i].id;
  }
}

constexpr unsigned kMostThreads = 4;  // each thread holds a full frame
constexpr std::size_t kCoarseViewImages = 48;

LampRow empty_row(const LampImage& image, LampStatus status) {
  LampRow row;
  row.id = image.id;
  row.image = image.name;
  row.t_s = image.t_s;
  row.status = status;
  return row;
}

LampPair find_lamps(const std::optional<LampScene>& scene, LampTracker& tracker, const Frame& frame,
                    const PairExpectation& expectation) {
  if (scene && scene->vision) return find_lamps(*scene->vision, tracker, frame, expectation);
  return tracker.locate(frame, expectation);
}

/// Adds the position on the plane. The tool's direction is known only when the lamps are told
/// apart; otherwise the position is known only if the end point lies midway between them.
void add_position(LampRow& row, const ToolPlace& place, bool told_apart, bool midway) {
  if (!told_apart && !midway) return;
  row.p_vision = place.seen.tip.p;
  row.sigma = place.seen.covariance.diagonal().cwiseSqrt();
  if (!told_apart) return;
  row.phi = place.seen.tip.phi;
  row.sigma_phi = place.seen.sigma_phi;
}

LampRow pair_row(const LampImage& image, const LampPair& pair, const ImageMotion& motion,
                 const std::optional<LampScene>& scene) {
  LampRow row = empty_row(image, pair.status);
  const auto now = observation_of(pair, image.t_s.value_or(0.0));
  if (!now) return row;
  const Observation seen = at_calibration(*now, motion);
  row.uv_px.assign(seen.lamps_px.begin(), seen.lamps_px.end());
  row.covariance_px2.assign(seen.covariances_px2.begin(), seen.covariances_px2.end());
  if (!seen.common_px2.isZero(0.0)) row.common_px2 = seen.common_px2;
  row.looks = {pair.lamps[0].look, pair.lamps[1].look};
  if (!scene || !scene->vision || pair.status == LampStatus::kWrongDistance) return row;
  if (const auto place = see_tool(*scene->vision, seen))
    add_position(row, *place, pair.status == LampStatus::kOk, scene->vision->tool.p_TP.isZero());
  return row;
}

/// Returns the distance of the only two lamps in a frame over the distance expected. Empty where
/// none is expected, or there are not two.
std::optional<double> distance_ratio(LampTracker& tracker, const Frame& frame,
                                     const PairExpectation& expectation) {
  if (!expectation.separation_px) return std::nullopt;
  tracker.forget();
  const LampPair pair = tracker.locate(frame, {});
  if (pair.status != LampStatus::kAmbiguous) return std::nullopt;
  const auto& [from, to] = *expectation.separation_px;
  return (pair.lamps[1].uv_px - pair.lamps[0].uv_px).norm() / (0.5 * (from + to));
}

LampRow disc_row(const LampImage& image, const LampCenter& disc) {
  LampRow row = empty_row(image, disc.status);
  if (disc.status != LampStatus::kOk) return row;
  row.uv_px = {disc.uv_px};
  row.covariance_px2 = {disc.covariance_px2};
  row.looks = {disc.look};
  return row;
}

std::optional<cv::Size> sensor_of(const LocateRequest& request) {
  return request.scene ? std::optional<cv::Size>(request.scene->sensor_px) : std::nullopt;
}

/// Collects the rows of images that are looked at in any order.
class Collector {
 public:
  explicit Collector(const LocateRequest& request)
      : request_(request),
        rows_(request.images.size()),
        times_(request.images.size()),
        wrong_distances_(request.images.size()),
        faults_(request.images.size()) {}

  /// Adds the row of image i, which look(frame) returns if the image can be read.
  template <typename Look>
  void add(std::size_t i, const Look& look) {
    const LampImage& image = request_.images[i];
    const LampImageRead read = read_lamp_image(image, sensor_of(request_));
    if (read.status != LampStatus::kOk) {
      rows_[i] = empty_row(image, read.status);
      faults_[i] = read.fault;
    } else {
      const auto start = std::chrono::steady_clock::now();
      rows_[i] = look(read.frame);
      const auto duration = std::chrono::steady_clock::now() - start;
      times_[i] = std::chrono::duration<double, std::milli>(duration).count();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (request_.progress) request_.progress(++done_, rows_.size());
  }

  void add_wrong_distance(std::size_t i, std::optional<double> ratio) {
    wrong_distances_[i] = ratio;
  }

  LocateReport finish() {
    Faults faults;
    for (const std::string& fault : faults_)
      if (!fault.empty()) faults.add({fault, "", "", Cause::kForeign});
    faults.throw_if_any();
    LocateReport report;
    report.rows = std::move(rows_);
    for (const auto& time : times_)
      if (time) report.milliseconds.push_back(*time);
    for (const auto& ratio : wrong_distances_)
      if (ratio) report.wrong_distances.push_back(*ratio);
    return report;
  }

 private:
  const LocateRequest& request_;
  std::vector<LampRow> rows_;
  std::vector<std::optional<double>> times_, wrong_distances_;
  std::vector<std::string> faults_;
  std::mutex mutex_;
  std::size_t done_{0};
};

/// Says what is known of the lamps before a coarse view is learned.
PairExpectation expectation_without_view(const LampScene& scene) {
  PairExpectation expectation;
  if (scene.fixed_px.empty()) return expectation;
  expectation.diameter_over_separation = scene.lamps.diameter_over_separation();
  expectation.fixed_px = scene.fixed_px;
  return expectation;
}

/// Learns a map from commanded poses to the image, from images spread over all poses of the arm. A
/// few pairs may be wrong; with more of them there is no map.
std::optional<CoarseView> learn_view(const LocateRequest& request, const LampScene& scene) {
  std::vector<const LampImage*> usable;
  for (const LampImage& image : request.images)
    if (image.commanded && !image.shows_board) usable.push_back(&image);
  const std::size_t n = std::min(usable.size(), kCoarseViewImages);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<CoarseViewRow> rows(n, {{kNone, kNone}, {kNone, kNone}});
  const PairExpectation expectation = expectation_without_view(scene);
  parallel_for(
      n, kMostThreads, [&] { return LampTracker(request.method); },
      [&](std::size_t i, LampTracker& tracker) {
        const LampImage& image = *usable[i * usable.size() / n];
        const LampImageRead read = read_lamp_image(image, sensor_of(request));
        if (read.status != LampStatus::kOk) return;
        tracker.forget();
        const LampPair pair = tracker.locate(read.frame, expectation);
        const auto& [first, second] = pair.lamps;
        if (pair.status != LampStatus::kAmbiguous && pair.status != LampStatus::kOk) return;
        rows[i] = {image.commanded->p, 0.5 * (first.uv_px + second.uv_px)};
      });
  return fit_coarse_view(rows);
}

/// Returns whether lamps that are fixed to the base can be followed through the images.
bool shows_fixed_lamps(const LocateRequest& request) {
  return request.scene && !request.scene->reference_lamps.empty() &&
         std::any_of(request.images.begin(), request.images.end(),
                     [](const LampImage& image) { return image.t_s.has_value(); });
}

/// Finds the fixed lamps in the images, and says in the scene where they are.
std::vector<ReferenceLamp> reference_lamps_in(const LocateRequest& request, LampScene& scene) {
  std::vector<ReferenceLamp> lamps;
  if (scene.vision) lamps = scene.vision->reference_lamps;
  const bool known = !lamps.empty();
  if (!known)
    lamps = find_reference_lamps(scene.reference_lamps, request.images, scene.sensor_px,
                                 request.method);
  scene.fixed_px = places_px(lamps);
  if (known) return lamps;
  name_reference_lamps(scene.reference_lamps, learn_view(request, scene), lamps);
  return lamps;
}

std::vector<LampImage> as_one_set(std::vector<LampImage> images) {
  const auto set = std::make_shared<const PictureSet>(each(images, &LampImage::file));
  for (LampImage& image : images) image.set = set;
  return images;
}

}  // namespace

LocateReport locate_lamps(const LocateRequest& request) {
  std::optional<LampScene> scene = request.scene;
  ReferenceTrack track;
  if (shows_fixed_lamps(request))
    track = {reference_lamps_in(request, *scene), request.images, scene->sensor_px, request.method};
  std::optional<LampPrediction> prediction;
  if (scene) prediction.emplace(*scene, scene->vision ? std::nullopt : learn_view(request, *scene));
  Collector collector(request);
  parallel_for(
      request.images.size(), kMostThreads, [&] { return LampTracker(request.method); },
      [&](std::size_t i, LampTracker& tracker) {
        const LampImage& image = request.images[i];
        collector.add(i, [&](const Frame& frame) {
          const PairExpectation expectation =
              prediction ? prediction->of(image.commanded) : PairExpectation{};
          tracker.forget();
          LampRow row = pair_row(image, find_lamps(scene, tracker, frame, expectation),
                                 track.at(image.t_s.value_or(0.0)), scene);
          if (row.status == LampStatus::kWrongDistance)
            collector.add_wrong_distance(i, distance_ratio(tracker, frame, expectation));
          return row;
        });
      });
  LocateReport report = collector.finish();
  report.reference_lamps = track.lamps();
  return report;
}

LocateReport follow_disc(const LocateRequest& request,
                         const std::optional<Eigen::Vector2d>& start_px) {
  DiscTracker tracker(request.method, start_px);
  Collector collector(request);
  for (std::size_t i = 0; i < request.images.size(); ++i) {
    collector.add(i, [&](const Frame& frame) {
      return disc_row(request.images[i], tracker.locate(frame.image));
    });
  }
  return collector.finish();
}

LocateReport locate_lamps_of_recording(const CellSettings& cell,
                                       const std::filesystem::path& folder,
                                       const std::vector<FrameRow>& frames, CenterMethod method) {
  return locate_lamps({images_of_recording(folder, frames, PlanarArm(cell.arm.geometry)),
                       read_lamp_scene(cell),
                       method,
                       {}});
}

std::vector<LampImage> images_of_recording(const std::filesystem::path& folder,
                                           const std::vector<FrameRow>& frames,
                                           const std::optional<PlanarArm>& arm) {
  std::vector<LampImage> images;
  for (const FrameRow& frame : frames) {
    images.push_back({frame.id, frame.image, folder / frame.image, frame.t_s, frame.region_px,
                      std::nullopt, shows_board(frame.plan)});
    if (arm && !shows_board(frame.plan)) images.back().commanded = arm->forward(frame.theta);
  }
  return as_one_set(std::move(images));
}

std::vector<LampImage> single_images(const std::vector<std::filesystem::path>& files) {
  return as_one_set(each(files, [](const std::filesystem::path& file) {
    return LampImage{file.stem().string(), file.string(), file, {}, {}, {}};
  }));
}

}  // namespace planar
