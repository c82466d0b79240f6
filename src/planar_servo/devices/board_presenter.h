#pragma once

namespace planar {

/// Puts the calibration board into the camera's view. A virtual cell does so by itself; a person is
/// guided instead.
class BoardPresenter {
 public:
  virtual ~BoardPresenter() = default;

  /// Holds the board tilted into the view. `view` counts from 0, and each number gives another
  /// pose.
  virtual void hold_board(int view) = 0;
  /// Lays the board on the plane of motion: view 0 in the middle of the camera's view and about
  /// square to it, each other anywhere that the camera sees the whole board, at any turn.
  virtual void lay_board(int view) = 0;
  virtual void remove_board() = 0;
};

}  // namespace planar
