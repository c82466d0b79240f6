#include "planar_servo/calibration/readings/clock_line.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

constexpr int kLineRounds = 4;

/// The straight line through the differences of the clocks, and what it leaves of each.
struct ClockLine {
  ClockLine(const std::vector<Meeting>& meetings, double middle_s) {
    const auto n = static_cast<Eigen::Index>(meetings.size());
    Eigen::MatrixXd A(n, 2);
    Eigen::VectorXd b(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Meeting& meeting = meetings[static_cast<std::size_t>(i)];
      A.row(i) << 1.0, meeting.look->span.middle_s() - middle_s;
      b[i] = meeting.rest->span.middle_s() - meeting.look->span.middle_s();
    }
    terms = solve_least_squares(A, b);
    const Eigen::VectorXd residuals = b - A * terms;
    left_s.assign(residuals.begin(), residuals.end());
    times_squares_s2 = (A.col(1).array() - A.col(1).mean()).square().sum();
  }

  double variance_s2() const {
    double squares = 0.0;
    for (const double left : left_s) squares += left * left;
    return squares / static_cast<double>(left_s.size() - 2);
  }

  Eigen::Vector2d terms;       ///< offset, seconds, and rate
  std::vector<double> left_s;  ///< in the order of the meetings
  double times_squares_s2;     ///< of the looks about their mean
};

/// Leaves out the meetings that lie far from the line: while a beam was broken the arm waited, and
/// the camera looked in the beginning of that rest instead of near its middle.
std::vector<Meeting> near_line(const ClockLine& line, const std::vector<Meeting>& meetings) {
  constexpr double kFarSigmas = 4.0;
  constexpr double kLeastSigma_s = 1e-3;  // clocks that agree exactly leave rounding only
  const double far_s = kFarSigmas * std::max(robust_sigma(line.left_s), kLeastSigma_s);
  std::vector<Meeting> near;
  for (std::size_t i = 0; i < meetings.size(); ++i)
    if (std::abs(line.left_s[i]) <= far_s) near.push_back(meetings[i]);
  return near;
}

/// Returns half the time by which a look may lie elsewhere within its rest, the mean.
double slack_s(const std::vector<Meeting>& meetings) {
  double sum = 0.0;
  for (const Meeting& m : meetings) {
    const double spare_s = m.rest->span.length_s() - m.look->span.length_s();
    sum += m.rest->span.length_s() > 0.0 ? std::max(0.0, 0.5 * spare_s) : kMeeting_s;
  }
  return sum / static_cast<double>(meetings.size());
}

}  // namespace

TrackerClock fit_clock(std::vector<Meeting> meetings, double middle_s) {
  ClockLine line(meetings, middle_s);
  for (int round = 0; round < kLineRounds; ++round) {
    meetings = near_line(line, meetings);
    line = ClockLine(meetings, middle_s);
  }
  TrackerClock clock{line.terms[0], line.terms[1], middle_s};
  const double variance_s2 = line.variance_s2(), slack = slack_s(meetings);
  // Where within a rest the camera looks is the same everywhere, and unknown.
  clock.sigma_offset_s =
      std::sqrt(variance_s2 / static_cast<double>(meetings.size()) + slack * slack / 3.0);
  clock.sigma_rate = std::sqrt(variance_s2 / line.times_squares_s2);
  clock.places = meetings.size();
  return clock;
}

}  // namespace planar
