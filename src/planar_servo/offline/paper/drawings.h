#pragma once

#include <Eigen/Core>
#include <string>

#include "planar_servo/calibration/board.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/offline/paper/page.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// A calibration board drawn on a page.
struct BoardPage {
  Board board;
  Page page;
  Eigen::Vector2d first_point_mm{0.0, 0.0};  ///< upper left dot or inner corner, on the page
  double mark_mm{0.0};                       ///< a dot's diameter or a square's side
  Eigen::Vector2d rulers_mm{0.0, 0.0};       ///< lengths of the lower and the left ruler
};

/// Draws the board of these words (see parse_board()) on the page that is stated (see
/// stated_page_mm()), or on one just large enough. Dots are 0.4 pitches wide and have 0.75 pitches
/// of paper around the outer centres, as the boards of virtual cells; a chessboard has a square's
/// width of white around it. Throws InputError for a board without pitch, and for one that does not
/// fit the page, with the largest pitch and the most points that do.
BoardPage board_page(const std::string& words, const std::string& page);

ReportList board_page_list(const BoardPage& drawn);

/// Where lamps and reflector are to be mounted on the tool, in metres.
struct ToolMount {
  LampLayout lamps;                   ///< the end point lies midway between them
  Eigen::Vector2d p_TS{0.0, -0.020};  ///< the reflector in the tool's frame T
  double ball_diameter{0.0381};       ///< of the reflector: an inch and a half
};

/// The tool drawn on a page.
struct ToolPage {
  ToolMount mount;
  Page page;
  Eigen::Vector2d end_point_mm{0.0, 0.0};  ///< on the page
};

/// Draws the tool from above, x_T to the right, on the page that is stated (see stated_page_mm())
/// or on one just large enough. Throws InputError when two parts overlap, and for too small a page.
ToolPage tool_page(const ToolMount& mount, const std::string& page);

ReportList tool_page_list(const ToolPage& drawn);

}  // namespace planar
