#pragma once

#include <functional>

#include "planar_servo/devices/board_presenter.h"
#include "planar_servo/devices/frame_source.h"
#include "planar_servo/files/tables/plan_table.h"

namespace planar {

/// Takes the views of the calibration board that a plan asks for.
class BoardSource {
 public:
  virtual ~BoardSource() = default;

  /// Returns a full frame that shows the board as the row asks. `view` counts the views of the
  /// row's plan from 0.
  virtual Frame take(const PlanRow& row, int view) = 0;
  /// Returns once the arm may move where the board was shown.
  virtual void clear_field() = 0;
};

/// The views of a cell that shows the board to its camera by itself.
class PresentedBoard final : public BoardSource {
 public:
  /// `grab` returns a full frame.
  PresentedBoard(BoardPresenter& presenter, std::function<Frame()> grab)
      : presenter_(presenter), grab_(std::move(grab)) {}

  Frame take(const PlanRow& row, int view) override {
    if (row.plan == Plan::kHeldBoard)
      presenter_.hold_board(view);
    else
      presenter_.lay_board(view);
    Frame frame = grab_();
    presenter_.remove_board();
    return frame;
  }
  void clear_field() override {}

 private:
  BoardPresenter& presenter_;
  std::function<Frame()> grab_;
};

}  // namespace planar
