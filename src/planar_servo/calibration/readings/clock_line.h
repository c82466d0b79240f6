#pragma once

#include <vector>

#include "planar_servo/calibration/readings/rests.h"
#include "planar_servo/calibration/readings/tracker_clock.h"

namespace planar {

constexpr double kMeeting_s = 0.5;  ///< by which looks may lie outside of a rest that they meet

/// A look and the rest in which it was taken.
struct Meeting {
  const Look* look;
  const Rest* rest;
};

/// Fits a clock to three meetings or more: the straight line through the differences of the clocks,
/// without the meetings that lie far from it.
TrackerClock fit_clock(std::vector<Meeting> meetings, double middle_s);

}  // namespace planar
