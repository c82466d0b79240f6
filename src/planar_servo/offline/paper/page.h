#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

struct _cairo;  // NOLINT(bugprone-reserved-identifier): cairo_t of <cairo.h>

namespace planar {

/// Draws in black on paper, in millimetres: x to the right and y down from the page's upper left
/// corner.
class Pen {
 public:
  enum class Align { kLeft, kMiddle, kRight };

  /// The unit of `cairo`, which must outlive the pen, is a millimetre.
  explicit Pen(_cairo* cairo);

  void disc(const Eigen::Vector2d& center, double diameter);
  void circle(const Eigen::Vector2d& center, double diameter);
  void square(const Eigen::Vector2d& corner, double side);
  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  /// Draws a line that ends in a full head at `to`.
  void arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  /// Writes one line of text. `at` is on its base line.
  void text(const Eigen::Vector2d& at, const std::string& words, Align align = Align::kLeft);
  double width_of(const std::string& words);

 private:
  _cairo* cairo_;
};

constexpr double kTextHeight_mm = 2.8;

/// A page that is printed at true scale.
struct Page {
  Eigen::Vector2d size_mm{0.0, 0.0};
  std::function<void(Pen&)> draw;
};

enum class PageFormat { kSvg, kPdf };

/// Returns the format that a file's ending asks for. Throws InputError unless it is .svg or .pdf.
PageFormat page_format(const std::filesystem::path& file);

/// The kind of files that page_text() makes, as require_writable() wants it.
constexpr char kPaperKind[] = "paper";

/// Returns the page as what its file holds.
std::string page_text(const Page& page, PageFormat format);

/// Returns the size of a page stated as A4, A3 (lying where `lies`) or WIDTHxHEIGHTmm; empty for an
/// empty text. Throws InputError for another text and for sides that no paper has.
std::optional<Eigen::Vector2d> stated_page_mm(const std::string& text, bool lies);

/// The frame of every drawing: rulers along the left and the lower side, by which a
/// printer's scale is checked, and a text below them.
class RuledPage {
 public:
  /// Takes the stated page or, without one, the smallest that has room for a drawing of this size.
  RuledPage(const std::optional<Eigen::Vector2d>& page_mm, const Eigen::Vector2d& drawing_mm,
            const std::string& text);

  const Eigen::Vector2d& page_mm() const { return page_mm_; }
  /// Returns the size of the largest drawing for which this page has room; may be negative.
  Eigen::Vector2d room_mm() const;
  /// Throws InputError unless there is room for this drawing; `remedy` says what would fit.
  void require_room(const Eigen::Vector2d& drawing_mm, const std::string& what,
                    const std::string& remedy = {}) const;
  /// Returns the upper left corner of a drawing of this size in the middle of the room.
  Eigen::Vector2d corner_of(const Eigen::Vector2d& drawing_mm) const;
  /// Returns the lengths of the lower and the left ruler: 100 mm, or the tens for which there is
  /// room.
  Eigen::Vector2d rulers_mm() const;

  void draw(Pen& pen) const;

 private:
  Eigen::Vector2d page_mm_;
  std::vector<std::string> lines_;
};

}  // namespace planar
