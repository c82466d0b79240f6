#include "planar_servo/report/live/record_view.h"

#include <visp3/core/vpImageDraw.h>

#include <algorithm>
#include <sstream>
#include <utility>

namespace planar {
namespace {

const vpColor kFixed(70, 140, 255);  // monuments, and dots of the views taken
constexpr double kWordsLeft = 548.0;
constexpr double kWordsHeight = 22.0;    // of a line
constexpr std::size_t kLineLength = 46;  // letters

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

/// Writes a paragraph and returns where the next begins.
double write_paragraph(Canvas& canvas, double y, const std::string& text, const vpColor& color) {
  for (const std::string& line : wrapped(text)) {
    canvas.write(kWordsLeft, y, line, color);
    y += kWordsHeight;
  }
  return y;
}

void draw_picture(const BoardView& view, Canvas& canvas) {
  const double scale = canvas.show(view.picture, kFramePanel);
  canvas.frame(kFramePanel);
  for (const cv::Rect2d& place : view.open_px)
    vpImageDraw::drawRectangle(
        canvas.picture(),
        vpRect(kFramePanel.x + scale * place.x, kFramePanel.y + scale * place.y,
               scale * place.width, scale * place.height),
        kWanted);
  const auto mark = [&](const std::vector<Eigen::Vector2d>& pixels, unsigned size,
                        const vpColor& color) {
    for (const Eigen::Vector2d& uv : pixels)
      vpImageDraw::drawCross(canvas.picture(),
                             Canvas::at(kFramePanel.x + scale * (uv.x() + 0.5),
                                        kFramePanel.y + scale * (uv.y() + 0.5)),
                             size, color, 1);
  };
  mark(view.covered_px, 3, kFixed);
  mark(view.dots_px, 7, view.good ? kSeen : kWanted);
}

void write_texts(const BoardView& view, Canvas& canvas) {
  double y = write_paragraph(canvas, kFramePanel.y, view.state, view.good ? kSeen : kWanted);
  y = write_paragraph(canvas, y + kWordsHeight, "next: " + view.wish, kInk);
  if (!view.lacks.empty()) {
    y = write_paragraph(canvas, y + kWordsHeight, "of the views so far", kFaint);
    for (const std::string& lack : view.lacks) y = write_paragraph(canvas, y, lack, kFaint);
  }
  write_paragraph(canvas, kFramePanel.y + kFramePanel.height - 2.0 * kWordsHeight,
                  "blue: dots of the views taken; orange frames: no view reaches there", kFaint);
}

constexpr double kMargin = 1.08;  // about what lies farthest out
constexpr double kHalfDot = 3.0;
constexpr unsigned kHereRing = 9;
constexpr double kBesideMark = 9.0, kLetterWidth = 9.0;

/// Where the base frame is in the panel.
class MapFrame {
 public:
  explicit MapFrame(const RecordView& view) {
    double farthest = 0.0;
    for (const RecordView::Circle& circle : view.borders)
      farthest = std::max(farthest, circle.p_B.cwiseAbs().maxCoeff() + circle.radius_m);
    for (const RecordView::Point& monument : view.monuments)
      farthest = std::max(farthest, monument.p_B.cwiseAbs().maxCoeff());
    for (const RecordView::Place& place : view.places)
      farthest = std::max(farthest, place.p_B.cwiseAbs().maxCoeff());
    if (farthest > 0.0) scale_ = 0.5 * kFramePanel.width / (kMargin * farthest);
  }

  double pixels(double length_m) const { return scale_ * length_m; }
  double x(const Eigen::Vector2d& p_B) const {
    return kFramePanel.x + 0.5 * kFramePanel.width + pixels(p_B.x());
  }
  double y(const Eigen::Vector2d& p_B) const {
    return kFramePanel.y + 0.5 * kFramePanel.height - pixels(p_B.y());
  }
  vpImagePoint at(const Eigen::Vector2d& p_B) const { return Canvas::at(x(p_B), y(p_B)); }

 private:
  double scale_{1.0};  // pixels per metre
};

void draw_mark(Canvas& canvas, double x, double y, PlaceMark mark) {
  const vpRect dot(x - kHalfDot, y - kHalfDot, 2.0 * kHalfDot, 2.0 * kHalfDot);
  switch (mark) {
    case PlaceMark::kToDo:
      return vpImageDraw::drawRectangle(canvas.picture(), dot, kFaint);
    case PlaceMark::kDone:
      return vpImageDraw::drawRectangle(canvas.picture(), dot, kSeen, true);
    case PlaceMark::kLeftOut:
      return vpImageDraw::drawRectangle(canvas.picture(), dot, kAlarm, true);
  }
}

void draw_map(const RecordView& view, Canvas& canvas) {
  const MapFrame map(view);
  canvas.frame(kFramePanel);
  for (const RecordView::Circle& circle : view.borders)
    vpImageDraw::drawCircle(canvas.picture(), map.at(circle.p_B),
                            static_cast<unsigned>(map.pixels(circle.radius_m)), kFaint);
  vpImageDraw::drawCross(canvas.picture(), map.at({0.0, 0.0}), 13, kInk, 1);
  for (const RecordView::Place& place : view.places)
    draw_mark(canvas, map.x(place.p_B), map.y(place.p_B), place.mark);
  for (const RecordView::Point& monument : view.monuments) {
    vpImageDraw::drawCross(canvas.picture(), map.at(monument.p_B), 13, kFixed, 2);
    // On the side of the middle, so that it stays within the panel.
    const double width = kLetterWidth * static_cast<double>(monument.id.size());
    const double offset = monument.p_B.x() > 0.0 ? -kBesideMark - width : kBesideMark;
    canvas.write(map.x(monument.p_B) + offset, map.y(monument.p_B) - 14.0, monument.id, kFixed);
  }
  if (view.here_B)
    vpImageDraw::drawCircle(canvas.picture(), map.at(*view.here_B), kHereRing, kWanted, 2);
}

void write_counts(const RecordView& view, Canvas& canvas) {
  double y = kFramePanel.y;
  canvas.write(kWordsLeft, y, view.now, kWanted);
  y += kWordsHeight;
  for (const std::string& count : view.counts)
    canvas.write(kWordsLeft, y += kWordsHeight, count, kInk);
}

void write_legend(Canvas& canvas) {
  double y = kFramePanel.y + kFramePanel.height - 6.0 * kWordsHeight;
  const auto line = [&](const std::string& text) {
    canvas.write(kWordsLeft + 20.0, y, text, kFaint);
    return std::exchange(y, y + kWordsHeight) + 0.25 * kWordsHeight;
  };
  const double x = kWordsLeft + 6.0;
  draw_mark(canvas, x, line("recorded"), PlaceMark::kDone);
  draw_mark(canvas, x, line("left out"), PlaceMark::kLeftOut);
  draw_mark(canvas, x, line("to be recorded"), PlaceMark::kToDo);
  vpImageDraw::drawCross(canvas.picture(), Canvas::at(x, line("monument")), 9, kFixed, 2);
  vpImageDraw::drawCross(canvas.picture(), Canvas::at(x, line("base; x right, y up")), 9, kInk, 1);
}

}  // namespace

ViewPlot plot_of(BoardView view) {
  return [view = std::move(view)](vpImage<vpRGBa>& picture) {
    Canvas canvas(picture);
    canvas.write(kFramePanel.x, 16, view.title, kInk);
    draw_picture(view, canvas);
    write_texts(view, canvas);
  };
}

ViewPlot plot_of(RecordView view) {
  return [view = std::move(view)](vpImage<vpRGBa>& picture) {
    Canvas canvas(picture);
    canvas.write(kFramePanel.x, 16, view.title, kInk);
    draw_map(view, canvas);
    write_counts(view, canvas);
    write_legend(canvas);
  };
}

}  // namespace planar
