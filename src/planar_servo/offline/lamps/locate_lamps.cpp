#include "planar_servo/offline/lamps/locate_lamps.h"

#include <chrono>
#include <limits>
#include <mutex>

#include "planar_servo/core/error.h"
#include "planar_servo/core/parallel.h"
#include "planar_servo/files/vision_files.h"
#include "planar_servo/lamps/disc_tracker.h"
#include "planar_servo/lamps/lamp_tracker.h"

namespace planar {
namespace {

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

void add_lamp(LampRow& row, const LampCenter& lamp) {
  row.uv_px.push_back(lamp.uv_px);
  row.covariance_px2.push_back(lamp.covariance_px2);
}

/// Sees the tool in a frame. Without a calibrated vision only its lamps are located.
SeenTool look(const std::optional<LampScene>& scene, LampTracker& tracker, const Frame& frame,
              const PairExpectation& expectation) {
  if (scene && scene->vision) return see_tool(*scene->vision, tracker, frame, expectation);
  return {tracker.locate(frame, expectation), std::nullopt};
}

/// Adds the position on the plane. The tool's direction is known only when the lamps are told
/// apart; otherwise the position is known only if the end point lies midway between them.
void add_position(LampRow& row, const ToolPlace& place, bool told_apart, bool midway) {
  if (!told_apart && !midway) return;
  row.p_vision = place.seen.p;
  row.sigma = place.covariance.diagonal().cwiseSqrt();
  if (!told_apart) return;
  row.phi = place.seen.phi;
  row.sigma_phi = place.sigma_phi;
}

LampRow pair_row(const LampImage& image, const SeenTool& seen,
                 const std::optional<LampScene>& scene) {
  LampRow row = empty_row(image, seen.lamps.status);
  for (const LampCenter& lamp : seen.lamps.lamps) {
    if (lamp.status != LampStatus::kOk) return row;
  }
  for (const LampCenter& lamp : seen.lamps.lamps) add_lamp(row, lamp);
  if (seen.place)
    add_position(row, *seen.place, seen.lamps.status == LampStatus::kOk,
                 scene->vision->tool.p_TP.isZero());
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
  if (disc.status == LampStatus::kOk) add_lamp(row, disc);
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
    for (const std::string& fault : faults_) {
      if (!fault.empty()) faults.add(fault);
    }
    faults.throw_if_any();
    LocateReport report;
    report.rows = std::move(rows_);
    for (const auto& time : times_) {
      if (time) report.milliseconds.push_back(*time);
    }
    for (const auto& ratio : wrong_distances_) {
      if (ratio) report.wrong_distances.push_back(*ratio);
    }
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

/// Learns a map from commanded poses to the image, from images spread over all poses of the arm. A
/// few pairs may be wrong; with more of them there is no map.
std::optional<CoarseView> learn_view(const LocateRequest& request) {
  std::vector<const LampImage*> usable;
  for (const LampImage& image : request.images) {
    if (image.commanded && !image.shows_board) usable.push_back(&image);
  }
  const std::size_t n = std::min(usable.size(), kCoarseViewImages);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<CoarseViewRow> rows(n, {{kNone, kNone}, {kNone, kNone}});
  parallel_for(
      n, kMostThreads, [&] { return LampTracker(request.method); },
      [&](std::size_t i, LampTracker& tracker) {
        const LampImage& image = *usable[i * usable.size() / n];
        const LampImageRead read = read_lamp_image(image, sensor_of(request));
        if (read.status != LampStatus::kOk) return;
        tracker.forget();
        const LampPair pair = tracker.locate(read.frame, {});
        if (pair.status != LampStatus::kAmbiguous) return;
        rows[i] = {image.commanded->p, 0.5 * (pair.lamps[0].uv_px + pair.lamps[1].uv_px)};
      });
  return fit_coarse_view(rows);
}

}  // namespace

LocateReport locate_lamps(const LocateRequest& request) {
  std::optional<LampPrediction> prediction;
  if (request.scene) {
    prediction.emplace(*request.scene, request.scene->vision ? std::nullopt : learn_view(request));
  }
  Collector collector(request);
  parallel_for(
      request.images.size(), kMostThreads, [&] { return LampTracker(request.method); },
      [&](std::size_t i, LampTracker& tracker) {
        const LampImage& image = request.images[i];
        collector.add(i, [&](const Frame& frame) {
          const PairExpectation expectation =
              prediction ? prediction->of(image.commanded) : PairExpectation{};
          tracker.forget();
          LampRow row =
              pair_row(image, look(request.scene, tracker, frame, expectation), request.scene);
          if (row.status == LampStatus::kWrongDistance)
            collector.add_wrong_distance(i, distance_ratio(tracker, frame, expectation));
          return row;
        });
      });
  return collector.finish();
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

std::vector<LampRow> locate_lamps_of_recording(const CellSettings& cell,
                                               const std::filesystem::path& folder,
                                               const std::vector<FrameRow>& frames,
                                               CenterMethod method) {
  return locate_lamps({images_of_recording(folder, frames, PlanarArm(cell.arm.geometry)),
                       read_lamp_scene(cell),
                       method,
                       {}})
      .rows;
}

}  // namespace planar
