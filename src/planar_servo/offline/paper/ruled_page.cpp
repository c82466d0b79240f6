#include "planar_servo/offline/paper/ruled_page.h"

#include <fmt/format.h>

#include <cmath>
#include <regex>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr double kMargin_mm = 5.0;  // what laser and ink-jet printers leave white
constexpr double kLeftRuler_mm = 14.0, kLowerRuler_mm = 11.0;  // with figures and distance
constexpr double kRulerLength_mm = 100.0;
constexpr double kRulerDistance_mm = 2.0;                        // from the drawing
constexpr double kFigures_mm = 4.2;                              // from a ruler to its figures
constexpr double kLeastWidth_mm = 80.0, kLeastHeight_mm = 20.0;  // for text and rulers
constexpr double kLeastPage_mm = 50.0, kLargestPage_mm = 5000.0;

/// Draws a ruler from `zero`, with ticks every millimetre to the side of its figures.
void draw_ruler(Pen& pen, const Eigen::Vector2d& zero, const Eigen::Vector2d& along,
                const Eigen::Vector2d& aside, double length_mm) {
  const bool is_lower = aside.y() > 0.0;
  pen.line(zero, zero + length_mm * along);
  for (int tick = 0; tick <= std::lround(length_mm); ++tick) {
    const double tick_mm = tick % 10 == 0 ? 3.5 : tick % 5 == 0 ? 2.5 : 1.5;
    const Eigen::Vector2d at = zero + tick * along;
    pen.line(at, at + tick_mm * aside);
    if (tick % 10 != 0) continue;
    const std::string figure = std::to_string(tick);
    const Eigen::Vector2d beside = at + kFigures_mm * aside;
    if (is_lower)
      pen.text(beside + Eigen::Vector2d(0.0, 0.7 * kTextHeight_mm), figure, Pen::Align::kMiddle);
    else
      pen.text(beside + Eigen::Vector2d(0.0, 0.36 * kTextHeight_mm), figure, Pen::Align::kRight);
  }
}

/// Returns what a page needs beside a drawing.
Eigen::Vector2d surroundings_mm(std::size_t lines) {
  return {2.0 * kMargin_mm + kLeftRuler_mm,
          2.0 * kMargin_mm + kLowerRuler_mm + static_cast<double>(lines) * kTextLine_mm};
}

Eigen::Vector2d with_least(const Eigen::Vector2d& drawing_mm) {
  return drawing_mm.cwiseMax(Eigen::Vector2d(kLeastWidth_mm, kLeastHeight_mm));
}

std::string size_text(const Eigen::Vector2d& size_mm) {
  return fmt::format("{:g} x {:g} mm", size_mm.x(), size_mm.y());
}

}  // namespace

std::optional<Eigen::Vector2d> stated_page_mm(const std::string& text, bool lies) {
  if (text.empty()) return std::nullopt;
  if (text == "A4") return lies ? Eigen::Vector2d(297.0, 210.0) : Eigen::Vector2d(210.0, 297.0);
  if (text == "A3") return lies ? Eigen::Vector2d(420.0, 297.0) : Eigen::Vector2d(297.0, 420.0);
  static const std::regex form(R"((\d{1,5}(?:\.\d+)?)x(\d{1,5}(?:\.\d+)?)mm)");
  std::smatch match;
  if (!std::regex_match(text, match, form))
    throw InputError(
        {"--page is '" + text + "'", "write A4, A3 or WIDTHxHEIGHTmm, as in 600x400mm"});
  const Eigen::Vector2d size_mm(std::stod(match[1]), std::stod(match[2]));
  if (size_mm.minCoeff() < kLeastPage_mm || size_mm.maxCoeff() > kLargestPage_mm)
    throw InputError({"--page is '" + text + "'", fmt::format("a side is {:g} to {:g} mm long",
                                                              kLeastPage_mm, kLargestPage_mm)});
  return size_mm;
}

RuledPage::RuledPage(const std::optional<Eigen::Vector2d>& page_mm,
                     const Eigen::Vector2d& drawing_mm, const std::string& text) {
  const double width_mm =
      page_mm ? page_mm->x() : with_least(drawing_mm).x() + surroundings_mm(0).x();
  lines_ = broken_lines(text, width_mm - 2.0 * kMargin_mm);
  page_mm_ = page_mm ? *page_mm : page_for_mm(with_least(drawing_mm));
}

Eigen::Vector2d RuledPage::room_mm() const {
  return page_mm_ - surroundings_mm(lines_.size());
}

Eigen::Vector2d RuledPage::page_for_mm(const Eigen::Vector2d& drawing_mm) const {
  return (drawing_mm + surroundings_mm(lines_.size())).array().ceil();
}

void RuledPage::require_room(const Eigen::Vector2d& drawing_mm, const std::string& what,
                             const std::string& remedy) const {
  constexpr double kRounding_mm = 1e-6;
  if (((room_mm() - drawing_mm).array() >= -kRounding_mm).all()) return;
  const RuledPage needed({}, drawing_mm, fmt::format("{}", fmt::join(lines_, " ")));
  throw InputError({fmt::format("{} needs a page of {}, but --page is {}", what,
                                size_text(needed.page_mm()), size_text(page_mm_)),
                    remedy + "without --page the page is as large as needed"});
}

Eigen::Vector2d RuledPage::corner_of(const Eigen::Vector2d& drawing_mm) const {
  return Eigen::Vector2d(kMargin_mm + kLeftRuler_mm, kMargin_mm) + 0.5 * (room_mm() - drawing_mm);
}

Eigen::Vector2d RuledPage::rulers_mm() const {
  return 10.0 * (0.1 * room_mm().cwiseMin(kRulerLength_mm)).array().floor();
}

void RuledPage::draw(Pen& pen) const {
  const Eigen::Vector2d zero(kMargin_mm + kLeftRuler_mm, kMargin_mm + room_mm().y());
  const Eigen::Vector2d right(1.0, 0.0), down(0.0, 1.0);
  draw_ruler(pen, zero + kRulerDistance_mm * down, right, down, rulers_mm().x());
  draw_ruler(pen, zero - kRulerDistance_mm * right, -down, -right, rulers_mm().y());
  Eigen::Vector2d at(kMargin_mm, zero.y() + kLowerRuler_mm + kTextHeight_mm);
  for (const std::string& line : lines_) {
    pen.text(at, line);
    at.y() += kTextLine_mm;
  }
}

}  // namespace planar
