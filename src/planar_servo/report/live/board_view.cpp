#include "planar_servo/report/live/board_view.h"

#include <visp3/core/vpImageDraw.h>

#include <sstream>
#include <utility>

#include "planar_servo/report/live/canvas.h"

namespace planar {
namespace {

const vpColor kCovered(70, 140, 255);
constexpr double kWordsLeft = 548.0;
constexpr double kWordsHeight = 22.0;
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
  mark(view.covered_px, 3, kCovered);
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

}  // namespace

ViewPlot plot_of(BoardView view) {
  return [view = std::move(view)](vpImage<vpRGBa>& picture) {
    Canvas canvas(picture);
    canvas.write(kFramePanel.x, 16, view.title, kInk);
    draw_picture(view, canvas);
    write_texts(view, canvas);
  };
}

}  // namespace planar
