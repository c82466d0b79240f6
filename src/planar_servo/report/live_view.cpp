#include "planar_servo/report/live_view.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <stdexcept>

namespace planar {
namespace {

const cv::Size kView(1000, 580);
const cv::Rect kPanel(16, 48, kLivePanel_px, kLivePanel_px);
const cv::Scalar kPaper(30, 26, 24);
constexpr int kLinesLeft = 548, kLineHeight = 22;
constexpr std::size_t kLineLength = 50;  // letters

cv::Scalar bgr(LiveView::Color color) {
  switch (color) {
    case LiveView::Color::kInk:
      return {230, 230, 230};
    case LiveView::Color::kFaint:
      return {110, 110, 110};
    case LiveView::Color::kSeen:
      return {90, 220, 60};
    case LiveView::Color::kWanted:
      return {40, 150, 255};
    case LiveView::Color::kAlarm:
      return {80, 80, 255};
    case LiveView::Color::kFixed:
      break;
  }
  return {255, 140, 70};
}

void write(cv::Mat& view, const cv::Point& at, const std::string& text, LiveView::Color color) {
  cv::putText(view, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, bgr(color), 1, cv::LINE_AA);
}

std::vector<std::string> wrapped(const std::string& text) {
  std::vector<std::string> lines{""};
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > kLineLength)
      lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

/// Returns the scale.
double draw_picture(cv::Mat& view, const cv::Mat& picture) {
  const double scale = std::min(static_cast<double>(kPanel.width) / picture.cols,
                                static_cast<double>(kPanel.height) / picture.rows);
  cv::Mat shown;
  cv::resize(picture, shown, {}, scale, scale, cv::INTER_AREA);
  cv::cvtColor(shown, view(cv::Rect(kPanel.tl(), shown.size())), cv::COLOR_GRAY2BGR);
  return scale;
}

void draw(cv::Mat& panel, const cv::Point& at, const LiveView::Mark& mark) {
  const int radius = cvRound(mark.radius_px);
  const cv::Point reach(radius, radius);
  switch (mark.shape) {
    case LiveView::Shape::kCross:
      return cv::drawMarker(panel, at, bgr(mark.color), cv::MARKER_CROSS, 2 * radius);
    case LiveView::Shape::kRing:
      return cv::circle(panel, at, radius, bgr(mark.color));
    case LiveView::Shape::kBox:
      return cv::rectangle(panel, at - reach, at + reach, bgr(mark.color), cv::FILLED);
  }
}

void draw_marks(cv::Mat panel, const LiveView& view, double scale) {
  for (const cv::Rect2d& open : view.open_px)
    cv::rectangle(panel, cv::Rect((open.tl() - view.corner_px) * scale, open.size() * scale),
                  bgr(LiveView::Color::kWanted));
  for (const LiveView::Mark& mark : view.marks) {
    const cv::Point at(cvFloor(scale * (mark.uv_px.x() - view.corner_px.x + 0.5)),
                       cvFloor(scale * (mark.uv_px.y() - view.corner_px.y + 0.5)));
    if (cv::Rect({}, panel.size()).contains(at)) draw(panel, at, mark);
  }
}

}  // namespace

cv::Mat drawn(const LiveView& view) {
  cv::Mat picture(kView, CV_8UC3, kPaper);
  write(picture, {kPanel.x, 28}, view.title, LiveView::Color::kInk);
  if (!view.picture.empty()) draw_marks(picture(kPanel), view, draw_picture(picture, view.picture));
  cv::rectangle(picture, kPanel, bgr(LiveView::Color::kFaint));
  cv::Point at(kLinesLeft, kPanel.y + kLineHeight / 2);
  for (const auto& [paragraph, color] : view.lines)
    for (const std::string& line : wrapped(paragraph)) {
      write(picture, at, line, color);
      at.y += kLineHeight;
    }
  return picture;
}

void LivePicture::show(const LiveView& view) {
  if (failed_) return;
  std::filesystem::path fresh = file_;
  fresh.replace_extension(".new.png");
  try {
    if (!cv::imwrite(fresh.string(), drawn(view))) throw std::runtime_error("cannot be written");
    std::filesystem::rename(fresh, file_);
  } catch (const std::exception& e) {
    failed_ = true;
    spdlog::warn(fmt::format("{}: {}; nothing more is drawn there", file_.string(), e.what()));
  }
}

}  // namespace planar
