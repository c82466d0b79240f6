#include "planar_servo/offline/paper/page.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>

#include <memory>
#include <sstream>
#include <stdexcept>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/atomic_file.h"

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

/// Says in a drawing's comment of what kind it is: in an SVG's second line, behind a PDF's end.
std::string marked(std::string text, PageFormat format) {
  if (format == PageFormat::kPdf) return text + format_remark(kPaperKind);
  return text.insert(text.find('\n') + 1, format_comment(kPaperKind));
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
    throw WorkError(std::string("the page cannot be drawn: ") + cairo_status_to_string(status));
  return marked(std::move(text), format);
}

}  // namespace planar
