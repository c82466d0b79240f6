#include "planar_servo/calibration/readings/tracker_clock.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "planar_servo/calibration/readings/clock_line.h"
#include "planar_servo/calibration/readings/rests.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

constexpr std::size_t kFewestMeetings = 10;  // twice as many as the view has terms
constexpr std::size_t kMostCandidates = 60;
constexpr double kLongRest = 10.0;       // times the median rest; such a one tells no time
constexpr double kFollowingShare = 0.1;  // of the field, which a view of the right clock misses
constexpr double kMostRate = 1e-3;
constexpr int kClockRounds = 4;

/// A clock that may be the right one, and what speaks for it.
struct Candidate {
  TrackerClock clock;
  std::vector<Meeting> meetings;
  double share{1.0};  ///< of the field by which an affine view misses the reflector
};

/// Leaves out the rests that last so long that any look meets them.
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

double shown(const TrackerClock& clock, double t_s) {
  return t_s + clock.offset_s + clock.rate * (t_s - clock.middle_s);
}

/// Brings every look to the rest nearest in time; each rest is met once.
std::vector<Meeting> meetings_of(const TrackerClock& clock, const std::vector<Look>& looks,
                                 const std::vector<Rest>& rests) {
  std::map<const Rest*, Meeting> met;
  for (const Look& look : looks) {
    const double at_s = shown(clock, look.span.middle_s());
    const auto distance = [at_s](const Rest& rest) {
      return std::abs(rest.span.middle_s() - at_s);
    };
    const auto later =
        std::lower_bound(rests.begin(), rests.end(), at_s,
                         [](const Rest& rest, double t_s) { return rest.span.middle_s() < t_s; });
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
  std::vector<double> squares;
  squares.reserve(meetings.size());
  for (Eigen::Index i = 0; i < n; ++i) squares.push_back(points.row(i).squaredNorm());
  std::sort(squares.begin(), squares.end());
  squares.resize(squares.size() - squares.size() / 10);
  double sum = 0.0;
  for (const double square : squares) sum += square;
  return spread > 0.0 ? std::sqrt(sum / static_cast<double>(squares.size())) / spread : 1.0;
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

/// A clock is another one when looks meet other rests by it.
bool same_clock(const Candidate& a, const Candidate& b) {
  return std::abs(a.clock.offset_s - b.clock.offset_s) < kMeeting_s;
}

[[noreturn]] void refuse_clock(const std::string& why) {
  throw InputError(
      "tracker: how its clock runs beside the camera's cannot be told: " + why +
      "; check the column t of the tracker's table, which counts seconds, or pair by id");
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
    refuse_clock("with no offset do the readings follow the lamps at ten places or more");
  std::sort(following.begin(), following.end(), [](const Candidate& a, const Candidate& b) {
    return static_cast<double>(a.meetings.size()) * (1.0 - a.share) >
           static_cast<double>(b.meetings.size()) * (1.0 - b.share);
  });
  const Candidate& best = following.front();
  for (const Candidate& other : following)
    if (!same_clock(best, other) && other.share < 2.0 * best.share + 0.01 &&
        10 * other.meetings.size() >= 9 * best.meetings.size())
      refuse_clock(fmt::format("{:.1f} s and {:.1f} s ahead of the camera's fit as well",
                               best.clock.offset_s, other.clock.offset_s));
  return best.clock;
}

}  // namespace planar
