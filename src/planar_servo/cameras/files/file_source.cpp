#include "planar_servo/cameras/files/file_source.h"

#include <visp3/core/vpImage.h>
#include <visp3/io/vpImageIo.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

bool is_picture(const fs::path& file) {
  static const std::vector<std::string> endings{".png", ".pgm", ".jpg", ".jpeg"};
  return std::find(endings.begin(), endings.end(), file.extension().string()) != endings.end();
}

std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> pictures;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && is_picture(entry.path())) pictures.push_back(entry.path());
  std::sort(pictures.begin(), pictures.end());
  return pictures;
}

/// Returns an empty image when the file cannot be read.
cv::Mat read_picture(const fs::path& file) {
  vpImage<unsigned char> picture;
  try {
    vpImageIo::read(picture, file.string());
  } catch (const vpException&) {
    return {};
  }
  return cv::Mat(static_cast<int>(picture.getHeight()), static_cast<int>(picture.getWidth()),
                 CV_8UC1, picture.bitmap)
      .clone();
}

}  // namespace

struct FileSource::Impl {
  /// Returns the next image, empty when it cannot be read; sets `over` after the last one.
  cv::Mat next_image() {
    cv::Mat image;
    if (video.isOpened()) {
      over = !video.read(image);
      if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
      return image;
    }
    over = taken >= pictures.size();
    return over ? image : read_picture(pictures[taken]);
  }

  std::vector<fs::path> pictures;
  cv::VideoCapture video;
  double frame_rate_hz{0.0};
  cv::Mat first;  ///< read to learn the size, not yet handed over
  cv::Size size_px;
  cv::Rect region_px;
  std::size_t taken{0};
  bool over{false};
  FrameCounts counts;
};

FileSource::FileSource(const fs::path& folder_or_video, double frame_rate_hz)
    : impl_(std::make_unique<Impl>()) {
  if (!(frame_rate_hz > 0.0)) throw InputError("the frame rate of files must be positive");
  impl_->frame_rate_hz = frame_rate_hz;
  if (fs::is_directory(folder_or_video)) {
    impl_->pictures = pictures_in(folder_or_video);
  } else if (impl_->video.open(folder_or_video.string(), cv::CAP_FFMPEG)) {  // not by guessing
    const double own_hz = impl_->video.get(cv::CAP_PROP_FPS);
    if (own_hz > 0.0) impl_->frame_rate_hz = own_hz;
  }
  impl_->first = impl_->next_image();
  if (impl_->first.empty())
    throw InputError(folder_or_video.string() +
                     ": holds no picture that can be read first; a folder of .png, .pgm or .jpg "
                     "files or a video is needed");
  impl_->size_px = impl_->first.size();
  impl_->region_px = cv::Rect({}, impl_->size_px);
}

FileSource::~FileSource() = default;

cv::Size FileSource::sensor_size_px() const {
  return impl_->size_px;
}

void FileSource::set_region(const cv::Rect& region_px) {
  require_region(region_px, impl_->size_px);
  impl_->region_px = region_px;
}

FrameResult FileSource::next_frame() {
  const cv::Mat image = impl_->taken == 0 ? impl_->first : impl_->next_image();
  if (impl_->over) return {FrameStatus::kLost, {}};
  const std::size_t id = impl_->taken++;
  if (image.size() != impl_->size_px) {
    ++impl_->counts.incomplete;
    return {FrameStatus::kIncomplete, {}};
  }
  ++impl_->counts.complete;
  const double t_s = static_cast<double>(id) / impl_->frame_rate_hz;
  return {FrameStatus::kOk, {image(impl_->region_px).clone(), impl_->region_px, t_s, id}};
}

std::optional<std::string> FileSource::fault() const {
  if (!impl_->over) return std::nullopt;
  return "there are no more pictures";
}

FrameCounts FileSource::counts() const {
  return impl_->counts;
}

void FileSource::set_exposure(const CameraExposure& /*exposure*/) {
  throw WorkError("pictures from files have been exposed already");
}

}  // namespace planar
