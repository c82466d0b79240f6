#pragma once

#include <string>
#include <vector>

#include "planar_servo/calibration/board/board_stance.h"
#include "planar_servo/core/plan.h"

namespace planar {

/// Something that one view of the board at least should show.
struct BoardWish {
  const char* request;  ///< to who holds the board: "tilt its left edge towards the camera"
  const char* lack;     ///< of a set of views: "none has its left edge nearer to the camera"
  bool (*granted)(const BoardStance& stance);
  bool is_needed{true};  ///< by what the views are taken for; otherwise it is only better so
};

/// Says what a view is worth beside those that were taken.
enum class ViewWorth {
  kNew,        ///< it shows something that is missing, or something else where nothing is needed
  kUnneeded,   ///< it differs from the others, but the views left are needed for what is missing
  kLikeTaken,  ///< a view like it was taken
};

/// Chooses views of the calibration board. Held views should reach the corners of the picture,
/// which fixes the lens's distortion, and be tilted to all sides, which fixes its focal length;
/// laid ones should lie first in the middle, then at the corners and turned. The order of the views
/// does not matter.
class ViewChoice {
 public:
  /// `plan` is kHeldBoard or kLaidBoard.
  explicit ViewChoice(Plan plan);

  void take(const std::string& id, const BoardStance& stance);

  /// Judges a view while `left` views are still to be taken, it included.
  ViewWorth worth(const BoardStance& stance, std::size_t left) const;
  /// Returns the id of a view that was taken like this one; empty when there is none.
  std::string like(const BoardStance& stance) const;

  /// Returns what no view has shown so far, places first.
  std::vector<BoardWish> missing() const;
  /// Returns the corners that no view reaches, though one should.
  std::vector<PictureCorner> open_corners() const;
  /// Says in words what the next view should show.
  std::string request() const;

 private:
  struct Taken {
    std::string id;
    BoardStance stance;
  };

  std::vector<BoardWish> ungranted(const std::vector<BoardWish>& wishes) const;
  /// Returns how many views are needed to grant what is missing; a view may grant a place and an
  /// attitude at once.
  std::size_t views_needed() const;

  Plan plan_;
  std::vector<BoardWish> first_;  ///< is granted before the others are asked for
  std::vector<BoardWish> places_, attitudes_;
  std::vector<Taken> taken_;
};

/// Returns whether two views show a board of about the same place, size, tilt and turn; of laid
/// boards place and turn count.
bool alike(Plan plan, const BoardStance& a, const BoardStance& b);

}  // namespace planar
