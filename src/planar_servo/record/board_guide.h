#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/view_choice.h"

namespace planar {

/// Says what is to be done with what the camera sees of the board now.
struct BoardAdvice {
  bool take{false};   ///< the view is to be taken
  bool good{false};   ///< the board only has to continue standing still
  std::string state;  ///< in words, for who holds it
};

/// Guides somebody who shows the calibration board to the camera: decides from what is seen when a
/// view is to be taken.
class BoardGuide {
 public:
  /// `exposure_s` is how long the camera exposes a picture; a held board may move by a quarter of a
  /// pixel meanwhile. A laid board must not move at all.
  BoardGuide(Plan plan, const Board& board, const cv::Size& sensor_px, double exposure_s);

  /// Notes a view that was taken, by the board's points.
  void take(const std::string& id, const std::vector<Eigen::Vector2d>& pixels);

  /// Takes no view from now on of a board that stands as in this one, which was shown for something
  /// else.
  void pass_over(const std::vector<Eigen::Vector2d>& pixels);

  /// Judges what was seen at this time, while `left` views are still to be taken. A board that
  /// stands still for a while is taken although it shows nothing that is missing, but no view is
  /// taken twice.
  BoardAdvice look(double t_s, const BoardSight& sight, std::size_t left);

  const ViewChoice& choice() const { return choice_; }
  /// Returns the points of all views that were taken.
  const std::vector<Eigen::Vector2d>& covered_px() const { return covered_px_; }

 private:
  struct Offer {
    BoardStance stance;
    double since_s;
  };

  std::string unseen(const BoardSight& sight) const;
  BoardAdvice judged(double t_s, const BoardStance& stance, std::size_t left);
  BoardAdvice unneeded(double t_s, const BoardStance& stance, const std::string& place);

  Plan plan_;
  Board board_;
  cv::Size sensor_px_;
  double still_s_;
  BoardRest rest_;
  ViewChoice choice_;
  std::vector<Eigen::Vector2d> covered_px_;
  std::optional<BoardStance> passed_over_;
  std::optional<Offer> offer_;  ///< a view that is held up although it shows nothing missing
};

/// Returns the board in words: "11 x 11 dots".
std::string words_of(const Board& board);

}  // namespace planar
