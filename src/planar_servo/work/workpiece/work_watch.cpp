#include "planar_servo/work/workpiece/work_watch.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <opencv2/imgcodecs.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/base/io/atomic_file.h"

namespace planar {
namespace {

constexpr int kFramesOfWatch = 2;
constexpr double kWatchPeriod_s = 60.0;

}  // namespace

std::vector<Frame> whole_frames(FrameSource& camera, int count,
                                const std::optional<double>& exposure_s) {
  const CameraExposure before = camera.exposure();
  const bool changes = exposure_s && *exposure_s != before.time_s;
  if (changes) camera.set_exposure({*exposure_s, before.gain_db});
  const AtEnd restored([&] {
    try {
      if (changes) camera.set_exposure(before);
    } catch (const std::exception& e) {
      spdlog::error(e.what());
    }
  });
  camera.set_region({{}, camera.sensor_size_px()});
  std::vector<Frame> frames;
  for (int missed = 0; static_cast<int>(frames.size()) < count;) {
    FrameResult result = frames.empty() ? camera.next_frame() : camera.following_frame();
    constexpr int kMostMissed = 5;
    if (result.status != FrameStatus::kOk && ++missed <= kMostMissed) continue;
    if (result.status != FrameStatus::kOk)
      throw WorkError({fmt::format("the camera gave no picture: {}", name(result.status)),
                       "planar-doctor says what is wrong with it", "", Cause::kDevice});
    result.frame.image = result.frame.image.clone();
    frames.push_back(std::move(result.frame));
  }
  return frames;
}

WorkFrames frames_of_work(FrameSource& camera, int count, const std::optional<double>& exposure_s) {
  WorkFrames frames;
  if (exposure_s) frames.of_lamps = whole_frames(camera, 1, std::nullopt).front();
  frames.of_marks = whole_frames(camera, count, exposure_s);
  return frames;
}

void write_picture(const std::filesystem::path& file, const cv::Mat& image,
                   const std::vector<int>& how) {
  std::vector<unsigned char> bytes;
  cv::imencode(file.extension().string(), image, bytes, how);
  write_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

bool WorkWatch::is_due() const {
  return works_ && (!looked_s_ || clock_.now_s() - *looked_s_ > kWatchPeriod_s);
}

std::string WorkWatch::examine(const StandAside& stand_aside) {
  if (!works_) return "";
  const std::string wrong = look();
  return hides_all_ && stand_aside() ? look() : wrong;
}

std::string WorkWatch::look() {
  hides_all_ = false;
  const WorkFrames frames = frames_of_work(camera_, kFramesOfWatch, works_->exposure_s);
  looked_s_ = clock_.now_s();
  std::string hidden;
  for (const FoundWork& work : works_->works) {
    const WorkMotion motion = look_again(frames.of_marks, vision_, work, frames.of_lamps);
    if (motion.moved)
      return *motion.moved +
             "; find it again with planar-find-work, and reach what is left in a "
             "folder of its own";
    for (const std::string& mark : motion.hidden)
      hidden += (hidden.empty() ? "" : ", ") + (work.id.empty() ? "" : work.id + "/") + mark;
    hides_all_ = motion.hidden.size() == work.fiducials.size();
    if (hides_all_)
      return fmt::format(
          "no mark of the work{} is seen where it was: it was moved or taken away, or something "
          "hides it; find it again with planar-find-work",
          work.id.empty() ? "" : " " + work.id);
  }
  if (!hidden.empty() && hidden != hidden_)
    spdlog::warn("marks of the work are hidden now, as by the arm: " + hidden);
  hidden_ = hidden;
  return "";
}

}  // namespace planar
