#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/operator.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/view_choice.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/report/live_view.h"
#include "planar_servo/work/record/recorder.h"

namespace planar {

/// Says what is to be done with what the camera sees of the board now.
struct BoardAdvice {
  enum class Next { kChange, kHoldStill, kTake };

  Next next{Next::kChange};
  std::string state;  ///< in words, for who holds it
};

/// Guides somebody who shows the calibration board to the camera: decides from what is seen when a
/// view is to be taken.
class BoardGuide {
 public:
  /// `exposure_s` is how long the camera exposes a picture; a held board may move by a quarter of a
  /// pixel meanwhile. A laid board must not move at all.
  BoardGuide(Purpose plan, const Board& board, const cv::Size& sensor_px, double exposure_s);

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

  Purpose plan_;
  Board board_;
  cv::Size sensor_px_;
  double still_s_;
  BoardRest rest_;
  ViewChoice choice_;
  std::vector<Eigen::Vector2d> covered_px_;
  std::optional<BoardStance> passed_over_;
  std::optional<Offer> offer_;  ///< a view that is held up although it shows nothing missing
};

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
    if (row.plan == Purpose::kHeldBoard)
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

/// Views of a board that a person holds before the camera or lays on the plane. The person is told
/// what is missing and sees on the display what the camera sees; each view is taken by itself, or
/// at once by Enter.
class GuidedBoard final : public BoardSource {
 public:
  /// `present` are the ids that the request's recording holds; the board is found in their images
  /// again. `request.board` must say which board it is. `display` may be null.
  GuidedBoard(const RecordRequest& request, const std::set<std::string>& present,
              FrameSource& camera, Clock& clock, Operator& person, LivePicture* display);

  /// Throws WorkError when asked to stop, when the camera sends no frame for a minute, and when
  /// nobody shows the board for ten.
  Frame take(const PlanRow& row, int view) override;
  /// Waits until the board is out of the picture and, at a terminal, Enter is pressed. Throws like
  /// take().
  void clear_field() override;

 private:
  /// The views of one plan, held or laid.
  struct Views {
    BoardGuide guide;
    std::size_t all{0}, left{0};
    bool begun{false};
  };

  cv::Size sensor_px() const;
  void find_again();
  void begin(const PlanRow& row, Views& views);
  void watch_anew();
  Frame next_frame(const std::string& id);
  bool is_taken(const PlanRow& row, const Frame& frame, Views& views);
  void show(const PlanRow& row, const Frame& frame, const BoardSight& sight,
            const BoardAdvice& advice, const Views& views);
  void note_sight(const std::string& id, bool is_seen, const BoardAdvice& advice);
  void conclude(const PlanRow& row, const Views& views);

  const RecordRequest& request_;
  Board board_;
  FrameSource& camera_;
  Clock& clock_;
  Operator& person_;
  LivePicture* display_;
  std::map<Purpose, Views> views_;
  std::vector<Eigen::Vector2d> last_px_;  ///< the board in the view taken last
  double seen_s_{0.0};  ///< when the board was seen last, on the clock, or the wait began
  bool warned_{false};  ///< that it was not seen since then
};

}  // namespace planar
