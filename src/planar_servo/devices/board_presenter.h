#pragma once

namespace planar {

/// Who puts the calibration board into the camera's view: a person, or the virtual cell.
class BoardPresenter {
 public:
  virtual ~BoardPresenter() = default;

  /// Holds the board into the view, tilted; `view` counts from 0, each number is another pose.
  virtual void hold_board(int view) = 0;
  /// Lays the board on the plane of motion; `view` counts from 0.
  virtual void lay_board(int view) = 0;
  virtual void remove_board() = 0;
};

}  // namespace planar
