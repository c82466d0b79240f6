#pragma once

#include <Eigen/Core>
#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/purpose.h"
#include "planar_servo/calibration/board.h"

namespace planar {

/// Measures for how long a board has been still: in all its sights, its points lie within a bound
/// of where they are now (root of the mean square distance).
class BoardRest {
 public:
  explicit BoardRest(double bound_px) : bound_px_(bound_px) {}

  /// Takes the points of the board as seen at this time, none when it is not seen. Times must not
  /// decrease.
  void see(double t_s, const std::vector<Eigen::Vector2d>& pixels);

  /// Returns the seconds, up to ten, for which it has been still; 0 unless it was seen twice.
  double still_for_s() const;

 private:
  struct Seen {
    double t_s;
    std::vector<Eigen::Vector2d> pixels;
  };

  double bound_px_;
  std::deque<Seen> seen_;  ///< while it stands still; the newest last
};

/// The corners of a picture, clockwise.
enum class PictureCorner { kUpperLeft, kUpperRight, kLowerRight, kLowerLeft };
constexpr std::array<PictureCorner, 4> kPictureCorners{
    PictureCorner::kUpperLeft, PictureCorner::kUpperRight, PictureCorner::kLowerRight,
    PictureCorner::kLowerLeft};

/// Returns the corner of a picture of this size, a sixth of each side.
cv::Rect2d corner_of_picture(PictureCorner corner, const cv::Size& picture_px);

/// Describes how a board is placed in a picture, as far as an uncalibrated camera shows it.
/// Directions are the picture's, x right and y down.
struct BoardStance {
  Eigen::Vector2d middle{0.0, 0.0};      ///< of the board, as shares of the picture's sides
  double size{0.0};                      ///< root of the share of the picture that it covers
  Eigen::Vector2d tilt{0.0, 0.0};        ///< radians, towards the edge that is nearer to the camera
  double turn{0.0};                      ///< radians, from the picture's rows to the board's
  double turn_period{0.0};               ///< radians, after which the board looks the same
  std::array<bool, 4> reaches_corner{};  ///< by PictureCorner: a dot lies in it

  bool reaches(PictureCorner corner) const {
    return reaches_corner[static_cast<std::size_t>(corner)];
  }
};

/// Estimates the stance of a board from its points in a picture of this size, by the homography
/// from the board. The gradient of the inverse depth over the picture, which is that of a plane
/// [Hartley and Zisserman 2004, 8.1], gives the tilt against the image plane, as it is under a lens
/// whose focal length is 1.5 times the picture's longer side; the lens's distortion counts as tilt,
/// so that differences of 10 degrees mean nothing. Empty without points, and when they lie on a
/// line.
std::optional<BoardStance> board_stance(const Board& board,
                                        const std::vector<Eigen::Vector2d>& pixels,
                                        const cv::Size& picture_px);

/// Returns how far a board's points in a picture are from those of a plane grid, rms, as a share of
/// their spread. A fisheye lens that sees 150 degrees bends a grid by a quarter of it; points in
/// another order miss by most of it. Zero where they lie on a line.
double off_grid_share(const Board& board, const std::vector<Eigen::Vector2d>& pixels);

/// Returns the angle in (-period/2, period/2] that differs from `angle` by whole periods.
double wrap_to_period(double angle, double period);

/// Something that at least one view of the board should show.
struct BoardWish {
  const char* request;  ///< to the person who holds it: "tilt its left edge towards the camera"
  const char* lack;     ///< of a set of views: "none has its left edge nearer to the camera"
  bool (*granted)(const BoardStance& stance);
  bool is_needed{true};  ///< for the purpose of the views; otherwise it is only better
};

/// What a view adds to those that were taken.
enum class ViewWorth {
  kNew,        ///< it shows what is missing, or is unlike the others when views can be spared
  kUnneeded,   ///< it is unlike the others, but all views left are needed for what is missing
  kLikeTaken,  ///< it is like a view that was taken
};

/// Chooses views of the calibration board. Held views should reach the corners of the picture,
/// which fixes the lens's distortion, and be tilted to all sides, which fixes its focal length;
/// laid ones should lie first in the middle, then at the corners and turned. The order of the views
/// does not matter.
class ViewChoice {
 public:
  /// `plan` is kHeldBoard or kLaidBoard.
  explicit ViewChoice(Purpose plan);

  void take(const std::string& id, const BoardStance& stance);

  /// Judges a view when `left` views, including this one, are still to be taken.
  ViewWorth worth(const BoardStance& stance, std::size_t left) const;
  /// Returns the id of a taken view that is like this one; empty when there is none.
  std::string like(const BoardStance& stance) const;

  /// Returns what no view has shown so far, places first.
  std::vector<BoardWish> missing() const;
  /// Returns the corners that no view reaches, though one should.
  std::vector<PictureCorner> open_corners() const;
  /// Returns in words what the next view should show.
  std::string request() const;

 private:
  struct Taken {
    std::string id;
    BoardStance stance;
  };

  std::vector<BoardWish> ungranted(const std::vector<BoardWish>& wishes) const;
  /// Returns how many views are needed to show what is missing; one view may show a place and an
  /// attitude at once.
  std::size_t views_needed() const;

  Purpose plan_;
  std::vector<BoardWish> first_;  ///< asked for before the others
  std::vector<BoardWish> places_, attitudes_;
  std::vector<Taken> taken_;
};

/// Returns whether two views show a board at about the same place, size, tilt and turn; of laid
/// boards only place and turn count.
bool alike(Purpose plan, const BoardStance& a, const BoardStance& b);

}  // namespace planar
