#include "planar_servo/calibration/readings/tracker_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kDensePeriod_s = 1.0;  // a tracker that reads all the time reads more often
constexpr double kLeastRestBound = 0.02 * kMillimetre;
constexpr double kRestSigmas = 6.0;
constexpr std::size_t kLeastRestReadings = 5;

bool is_dense(const std::vector<ToolReading>& sorted) {
  if (sorted.size() < 2 * kLeastRestReadings) return false;
  std::vector<double> gaps;
  gaps.reserve(sorted.size());
  for (std::size_t i = 1; i < sorted.size(); ++i) gaps.push_back(sorted[i].t_s - sorted[i - 1].t_s);
  return median(gaps) < kDensePeriod_s;
}

/// Returns where the run of readings near the one at `first` ends.
std::size_t end_of_run(const std::vector<ToolReading>& sorted, std::size_t first) {
  const double bound = std::max(kLeastRestBound, kRestSigmas * sorted[first].sigma);
  std::size_t end = first + 1;
  while (end < sorted.size() && (sorted[end].p_B - sorted[first].p_B).norm() <= bound) ++end;
  return end;
}

}  // namespace

std::vector<ToolReading> readings_at_rest(std::vector<ToolReading> readings) {
  std::stable_sort(readings.begin(), readings.end(),
                   [](const ToolReading& a, const ToolReading& b) { return a.t_s < b.t_s; });
  if (!is_dense(readings)) return readings;
  std::vector<ToolReading> resting;
  for (std::size_t first = 0; first < readings.size();) {
    const std::size_t end = end_of_run(readings, first);
    // The first and the last reading of a rest may be of a motion that begins or ends.
    for (std::size_t i = first + 1; end - first >= kLeastRestReadings && i + 1 < end; ++i)
      resting.push_back(readings[i]);
    first = end;
  }
  return resting;
}

namespace {

/// A stretch of time, on one clock.
struct TimeSpan {
  double begin_s{0.0}, end_s{0.0};
  double middle_s() const { return 0.5 * (begin_s + end_s); }
  double length_s() const { return end_s - begin_s; }
};

/// A rest of the reflector.
struct Rest {
  TimeSpan span;  ///< on the tracker's clock
  Eigen::Vector3d p_B{0.0, 0.0, 0.0};
};

/// A look of the camera at the resting tool.
struct Look {
  TimeSpan span;  ///< on the camera's clock
  std::array<Eigen::Vector2d, 2> lamps_px;
};

/// Returns where the reflector rested, in order of time. `sorted` are the readings of
/// readings_at_rest().
std::vector<Rest> rests_of(const std::vector<ToolReading>& sorted) {
  std::vector<Rest> rests;
  for (std::size_t first = 0; first < sorted.size();) {
    const std::size_t end = end_of_run(sorted, first);
    Rest rest{{sorted[first].t_s, sorted[end - 1].t_s}};
    for (std::size_t i = first; i < end; ++i)
      rest.p_B += sorted[i].p_B / static_cast<double>(end - first);
    rests.push_back(rest);
    first = end;
  }
  return rests;
}

/// Returns a look for each place whose lamps were found, in the order of the places' names.
std::vector<Look> looks_of(const std::vector<LampSight>& frames) {
  std::map<std::string, Look> by_id;
  for (const LampSight& frame : frames) {
    if (!frame.fault.empty()) continue;
    Look& look =
        by_id.try_emplace(frame.id, Look{{frame.t_s, frame.t_s}, frame.lamps_px}).first->second;
    look.span.begin_s = std::min(look.span.begin_s, frame.t_s);
    look.span.end_s = std::max(look.span.end_s, frame.t_s);
  }
  std::vector<Look> looks;
  looks.reserve(by_id.size());
  for (const auto& [id, look] : by_id) looks.push_back(look);
  return looks;
}

constexpr double kMeeting_s = 0.5;  ///< by which looks may lie outside of a rest that they meet

/// A look and the rest in which it was taken.
struct Meeting {
  const Look* look;
  const Rest* rest;
};

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
    variance_s2 = residuals.squaredNorm() / static_cast<double>(n - 2);
    times_squares_s2 = (A.col(1).array() - A.col(1).mean()).square().sum();
  }

  Eigen::Vector2d terms;       ///< offset, seconds, and rate
  std::vector<double> left_s;  ///< in the order of the meetings
  double variance_s2;
  double times_squares_s2;  ///< of the looks about their mean
};

/// Leaves out the meetings far from the line: while the beam was broken the arm waited, and the
/// camera looked at the beginning of that rest instead of near its middle.
std::vector<Meeting> near_line(const ClockLine& line, const std::vector<Meeting>& meetings) {
  constexpr double kFarSigmas = 4.0;
  constexpr double kLeastSigma_s = 1e-3;  // clocks that agree exactly leave rounding only
  const double far_s = kFarSigmas * std::max(robust_sigma(line.left_s), kLeastSigma_s);
  const double most_s = median(line.left_s);  // where they lie, also when a clock was set meanwhile
  std::vector<Meeting> near;
  for (std::size_t i = 0; i < meetings.size(); ++i)
    if (std::abs(line.left_s[i] - most_s) <= far_s) near.push_back(meetings[i]);
  return near;
}

/// Returns the mean of half the time by which looks could be shifted within their rests.
double slack_s(const std::vector<Meeting>& meetings) {
  double sum = 0.0;
  for (const Meeting& m : meetings) {
    const double spare_s = m.rest->span.length_s() - m.look->span.length_s();
    sum += m.rest->span.length_s() > 0.0 ? std::max(0.0, 0.5 * spare_s) : kMeeting_s;
  }
  return sum / static_cast<double>(meetings.size());
}

/// Fits a clock to three meetings or more: the straight line through the differences of the clocks,
/// without the meetings that lie far from it.
TrackerClock fit_clock(std::vector<Meeting> meetings, double middle_s) {
  ClockLine line(meetings, middle_s);
  for (int round = 0; round < kLineRounds; ++round) {
    meetings = near_line(line, meetings);
    line = ClockLine(meetings, middle_s);
  }
  TrackerClock clock{line.terms[0], line.terms[1], middle_s};
  const double slack = slack_s(meetings);
  // Where within a rest the camera looks is the same everywhere, and unknown.
  clock.sigma_offset_s =
      std::sqrt(line.variance_s2 / static_cast<double>(meetings.size()) + slack * slack / 3.0);
  clock.sigma_rate = std::sqrt(line.variance_s2 / line.times_squares_s2);
  clock.places = meetings.size();
  return clock;
}

constexpr std::size_t kFewestMeetings = 10;  // twice as many as the view has terms
constexpr std::size_t kMostCandidates = 60;
constexpr double kLongRest = 10.0;       // times the median rest; such a one tells no time
constexpr double kFollowingShare = 0.1;  // of the field, which a view of the right clock misses
constexpr double kMostRate = 1e-3;
constexpr int kClockRounds = 4;

/// A possible clock, and the evidence for it.
struct Candidate {
  TrackerClock clock;
  std::vector<Meeting> meetings;
  double share{1.0};  ///< of the field by which an affine view misses the reflector
};

/// Leaves out rests that are so long that any look falls into them.
std::vector<Rest> telling(const std::vector<Rest>& rests) {
  if (rests.empty()) return {};
  std::vector<double> lengths;
  lengths.reserve(rests.size());
  for (const Rest& rest : rests) lengths.push_back(rest.span.length_s());
  const double longest = kLongRest * median(lengths) + kMeeting_s;
  std::vector<Rest> kept;
  std::copy_if(rests.begin(), rests.end(), std::back_inserter(kept),
               [&](const Rest& rest) { return rest.span.length_s() <= longest; });
  return kept;
}

/// Returns the offsets that bring most looks into rests, those with most first.
std::vector<double> likely_offsets(const std::vector<Look>& looks, const std::vector<Rest>& rests) {
  std::vector<std::pair<double, int>> ends;
  ends.reserve(2 * looks.size() * rests.size());
  for (const Look& look : looks)
    for (const Rest& rest : rests) {
      const double low = rest.span.begin_s - look.span.begin_s - kMeeting_s;
      const double high = rest.span.end_s - look.span.end_s + kMeeting_s;
      if (low > high) continue;
      ends.emplace_back(low, 1);
      ends.emplace_back(high, -1);
    }
  std::sort(ends.begin(), ends.end());
  std::vector<std::pair<int, double>> peaks;  // how many meet, and the offset
  int meeting = 0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    meeting += ends[i].second;
    if (ends[i].second > 0 && ends[i + 1].second < 0)
      peaks.emplace_back(-meeting, 0.5 * (ends[i].first + ends[i + 1].first));
  }
  std::sort(peaks.begin(), peaks.end());
  std::vector<double> offsets;
  for (const auto& [count, offset] : peaks) {
    if (offsets.size() == kMostCandidates) break;
    if (std::none_of(offsets.begin(), offsets.end(),
                     [o = offset](double other) { return std::abs(o - other) < kMeeting_s; }))
      offsets.push_back(offset);
  }
  return offsets;
}

/// Matches every look with the rest nearest in time; each rest is matched once.
std::vector<Meeting> meetings_of(const TrackerClock& clock, const std::vector<Look>& looks,
                                 const std::vector<Rest>& rests) {
  std::map<const Rest*, Meeting> met;
  for (const Look& look : looks) {
    const double t_s = look.span.middle_s();
    const double at_s = t_s + clock.offset_s + clock.rate * (t_s - clock.middle_s);
    const auto distance = [at_s](const Rest& rest) {
      return std::abs(rest.span.middle_s() - at_s);
    };
    const auto later = std::lower_bound(
        rests.begin(), rests.end(), at_s,
        [](const Rest& rest, double time_s) { return rest.span.middle_s() < time_s; });
    const Rest* nearest = nullptr;
    if (later != rests.end()) nearest = &*later;
    if (later != rests.begin() &&
        (nearest == nullptr || distance(*(later - 1)) < distance(*nearest)))
      nearest = &*(later - 1);
    if (nearest == nullptr || at_s < nearest->span.begin_s - kMeeting_s ||
        at_s > nearest->span.end_s + kMeeting_s)
      continue;
    met.try_emplace(nearest, Meeting{&look, nearest});
  }
  std::vector<Meeting> meetings;
  meetings.reserve(met.size());
  for (const auto& [rest, meeting] : met) meetings.push_back(meeting);
  return meetings;
}

/// Returns the share of the reflector's spread that an affine view of the lamps' middle and
/// direction leaves, nine tenths of the places.
double share_missed(const std::vector<Meeting>& meetings) {
  const auto n = static_cast<Eigen::Index>(meetings.size());
  Eigen::MatrixXd A(n, 5);
  Eigen::MatrixX2d points(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Meeting& m = meetings[static_cast<std::size_t>(i)];
    const Eigen::Vector2d middle = 0.5 * (m.look->lamps_px[0] + m.look->lamps_px[1]);
    const Eigen::Vector2d axis = (m.look->lamps_px[1] - m.look->lamps_px[0]).normalized();
    A.row(i) << 1.0, 1e-3 * middle.x(), 1e-3 * middle.y(), axis.x(), axis.y();
    points.row(i) = m.rest->p_B.head<2>().transpose();
  }
  const Eigen::MatrixX2d centred = points.rowwise() - points.colwise().mean();
  const double spread = std::sqrt(centred.rowwise().squaredNorm().mean());
  for (int axis = 0; axis < 2; ++axis)
    points.col(axis) -= A * solve_least_squares(A, Eigen::VectorXd(points.col(axis)));
  const Eigen::VectorXd left = points.rowwise().norm();
  std::vector<double> lengths{left.begin(), left.end()};
  std::sort(lengths.begin(), lengths.end());
  lengths.resize(lengths.size() - lengths.size() / 10);
  return spread > 0.0 ? rms(lengths) / spread : 1.0;
}

std::optional<Candidate> candidate_of(double offset_s, double middle_s,
                                      const std::vector<Look>& looks,
                                      const std::vector<Rest>& rests) {
  Candidate candidate;
  candidate.clock = {offset_s, 0.0, middle_s};
  for (int round = 0; round < kClockRounds; ++round) {
    candidate.meetings = meetings_of(candidate.clock, looks, rests);
    if (candidate.meetings.size() < kFewestMeetings) return std::nullopt;
    candidate.clock = fit_clock(candidate.meetings, middle_s);
    if (!(std::abs(candidate.clock.rate) < kMostRate)) return std::nullopt;
  }
  candidate.share = share_missed(candidate.meetings);
  return candidate;
}

[[noreturn]] void refuse_clock(const std::string& why, Cause cause = Cause::kInsufficient) {
  throw InputError({"its clock cannot be related to the camera's: " + why,
                    "check that its column t is in seconds and no clock was set, or pair by id",
                    "tracker", cause});
}

}  // namespace

TrackerClock estimate_tracker_clock(const std::vector<LampSight>& frames,
                                    const std::vector<ToolReading>& readings) {
  const std::vector<Look> looks = looks_of(frames);
  const std::vector<Rest> rests = telling(rests_of(readings));
  if (looks.size() < kFewestMeetings || rests.size() < kFewestMeetings)
    refuse_clock(fmt::format("{} places and {} rests of the tracker are too few; {} are needed",
                             looks.size(), rests.size(), kFewestMeetings));
  TimeSpan recording = looks.front().span;
  for (const Look& look : looks) {
    recording.begin_s = std::min(recording.begin_s, look.span.begin_s);
    recording.end_s = std::max(recording.end_s, look.span.end_s);
  }
  std::vector<Candidate> following;
  for (const double offset_s : likely_offsets(looks, rests)) {
    auto candidate = candidate_of(offset_s, recording.middle_s(), looks, rests);
    if (candidate && candidate->share < kFollowingShare) following.push_back(std::move(*candidate));
  }
  if (following.empty())
    refuse_clock("no offset makes the readings follow the lamps at ten places or more",
                 Cause::kContradiction);
  std::sort(following.begin(), following.end(), [](const Candidate& a, const Candidate& b) {
    return static_cast<double>(a.meetings.size()) * (1.0 - a.share) >
           static_cast<double>(b.meetings.size()) * (1.0 - b.share);
  });
  const Candidate& best = following.front();
  // Clocks differ when they match looks with different rests.
  for (const Candidate& other : following)
    if (std::abs(best.clock.offset_s - other.clock.offset_s) >= kMeeting_s &&
        other.share < 2.0 * best.share + 0.01 &&
        10 * other.meetings.size() >= 9 * best.meetings.size())
      refuse_clock(fmt::format("offsets of {:.1f} s and {:.1f} s fit equally well",
                               best.clock.offset_s, other.clock.offset_s));
  return best.clock;
}

}  // namespace planar
