#include "planar_servo/offline/paper/page.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <regex>
#include <sstream>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"

namespace planar {
namespace {

constexpr double kLineWidth_mm = 0.15;
constexpr double kArrowHead_mm = 1.6;
constexpr double kPointsPerMm = 72.0 / 25.4;

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Cairo = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

cairo_status_t append(void* text, const unsigned char* bytes, unsigned int count) {
  static_cast<std::string*>(text)->append(bytes, bytes + count);
  return CAIRO_STATUS_SUCCESS;
}

/// Opens a surface that appends what is drawn to `text`.
Surface surface_of(const Page& page, PageFormat format, std::string& text) {
  if (format == PageFormat::kPdf)
    return {cairo_pdf_surface_create_for_stream(append, &text, kPointsPerMm * page.size_mm.x(),
                                                kPointsPerMm * page.size_mm.y()),
            cairo_surface_destroy};
  Surface surface(
      cairo_svg_surface_create_for_stream(append, &text, page.size_mm.x(), page.size_mm.y()),
      cairo_surface_destroy);
  cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_MM);
  return surface;
}

constexpr double kTextLine_mm = 4.2;  // from one base line to the next
constexpr double kMargin_mm = 5.0;    // what laser and ink-jet printers leave white
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

/// Breaks a text between words into lines of at most this width; only a longer word is wider.
std::vector<std::string> broken_lines(const std::string& text, double width_mm) {
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1), cairo_surface_destroy);
  const Cairo cairo(cairo_create(surface.get()), cairo_destroy);
  Pen pen(cairo.get());
  std::vector<std::string> lines;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.empty() && pen.width_of(lines.back() + " " + word) <= width_mm)
      lines.back() += " " + word;
    else
      lines.push_back(word);
  }
  return lines;
}

}  // namespace

Pen::Pen(_cairo* cairo) : cairo_(cairo) {
  cairo_set_line_width(cairo, kLineWidth_mm);
  cairo_select_font_face(cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, kTextHeight_mm);
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(cairo, options);
  cairo_font_options_destroy(options);
}

void Pen::disc(const Eigen::Vector2d& center, double diameter) {
  cairo_arc(cairo_, center.x(), center.y(), 0.5 * diameter, 0.0, 2.0 * kPi);
  cairo_fill(cairo_);
}

void Pen::circle(const Eigen::Vector2d& center, double diameter) {
  cairo_arc(cairo_, center.x(), center.y(), 0.5 * diameter, 0.0, 2.0 * kPi);
  cairo_stroke(cairo_);
}

void Pen::square(const Eigen::Vector2d& corner, double side) {
  cairo_rectangle(cairo_, corner.x(), corner.y(), side, side);
  cairo_fill(cairo_);
}

void Pen::line(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  cairo_move_to(cairo_, from.x(), from.y());
  cairo_line_to(cairo_, to.x(), to.y());
  cairo_stroke(cairo_);
}

void Pen::arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  line(from, to);
  const Eigen::Vector2d along = kArrowHead_mm * (to - from).normalized();
  const Eigen::Vector2d aside = 0.3 * Eigen::Vector2d(-along.y(), along.x());
  const Eigen::Vector2d left = to - along + aside, right = to - along - aside;
  cairo_move_to(cairo_, to.x(), to.y());
  cairo_line_to(cairo_, left.x(), left.y());
  cairo_line_to(cairo_, right.x(), right.y());
  cairo_fill(cairo_);
}

void Pen::text(const Eigen::Vector2d& at, const std::string& words, Align align) {
  const double share = align == Align::kLeft ? 0.0 : align == Align::kMiddle ? 0.5 : 1.0;
  cairo_move_to(cairo_, at.x() - share * width_of(words), at.y());
  cairo_show_text(cairo_, words.c_str());
  cairo_new_path(cairo_);  // or what follows would be joined to the text's end
}

double Pen::width_of(const std::string& words) {
  cairo_text_extents_t extents;
  cairo_text_extents(cairo_, words.c_str(), &extents);
  return extents.x_advance;
}

PageFormat page_format(const std::filesystem::path& file) {
  if (file.extension() == ".svg") return PageFormat::kSvg;
  if (file.extension() == ".pdf") return PageFormat::kPdf;
  throw InputError({"is neither an .svg nor a .pdf", "name it so; the ending chooses", file});
}

std::string page_text(const Page& page, PageFormat format) {
  std::string text;
  const Surface surface = surface_of(page, format, text);
  {
    const Cairo cairo(cairo_create(surface.get()), cairo_destroy);
    if (format == PageFormat::kPdf) cairo_scale(cairo.get(), kPointsPerMm, kPointsPerMm);
    Pen pen(cairo.get());
    page.draw(pen);
    cairo_show_page(cairo.get());
  }
  cairo_surface_finish(surface.get());
  if (const cairo_status_t status = cairo_surface_status(surface.get()))
    throw WorkError(std::string("the page cannot be drawn: ") + cairo_status_to_string(status),
                    Cause::kSystem);
  // A comment says of what kind it is: in an SVG's second line, behind a PDF's end.
  if (format == PageFormat::kPdf) return text + format_remark(kPaperKind);
  return text.insert(text.find('\n') + 1, format_comment(kPaperKind));
}

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
  page_mm_ = (with_least(drawing_mm) + surroundings_mm(lines_.size())).array().ceil();
  if (page_mm) page_mm_ = *page_mm;
}

Eigen::Vector2d RuledPage::room_mm() const {
  return page_mm_ - surroundings_mm(lines_.size());
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
