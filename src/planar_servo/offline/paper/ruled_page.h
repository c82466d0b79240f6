#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/offline/paper/page.h"

namespace planar {

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
  Eigen::Vector2d page_for_mm(const Eigen::Vector2d& drawing_mm) const;

  Eigen::Vector2d page_mm_;
  std::vector<std::string> lines_;
};

}  // namespace planar
