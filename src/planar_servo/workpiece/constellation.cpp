#include "planar_servo/workpiece/constellation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// A mark may be this far from where its drawing has it, or this share of its distance from the
/// others: vision before compensation, paper that shrank by a per cent.
constexpr double kCapture_m = 0.5e-3, kCaptureShare = 0.01;
/// Two poses closer than this are one.
constexpr double kSamePose_m = 2e-3;
constexpr double kMarkSizeShare = 0.12;  ///< of a mark's nominal size

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

/// The drawing as it lies, or as it would lie face down.
struct Hypothesis {
  Eigen::Matrix2d A;
  Eigen::Vector2d t;
  std::vector<std::size_t> candidates;  ///< kNone for a mark without one
  std::size_t found{0};
  double square_m2{0.0};

  Eigen::Vector2d at(const Eigen::Vector2d& p_W) const { return A * p_W + t; }
  bool takes(std::size_t candidate) const {
    return std::find(candidates.begin(), candidates.end(), candidate) != candidates.end();
  }
};

bool fits(const Fiducial& mark, const MarkCandidate& candidate) {
  if (candidate.kind != mark.kind || candidate.z != mark.z) return false;
  if (!may_have_tag(mark, candidate.sight.tag)) return false;
  return mark.kind == FiducialKind::kChessCorner ||
         std::abs(candidate.size - mark.size) < kMarkSizeShare * mark.size;
}

class Matcher {
 public:
  Matcher(const std::vector<Fiducial>& drawing, const std::vector<MarkCandidate>& candidates,
          const std::optional<WorkPlace>& place)
      : drawing_(drawing), candidates_(candidates), place_(place), fitting_(drawing.size()) {
    for (std::size_t i = 0; i < drawing.size(); ++i)
      for (std::size_t k = 0; k < candidates.size(); ++k)
        if (fits(drawing[i], candidates[k])) fitting_[i].push_back(k);
  }

  /// Returns the best hypotheses, those with the most marks, one for each pose.
  std::vector<Hypothesis> best(bool mirrored) const {
    std::vector<Hypothesis> found;
    for (const auto& [i, j] : seed_pairs())
      for (const std::size_t a : fitting_[i])
        for (const std::size_t b : fitting_[j])
          if (a != b) add(found, hypothesis(i, j, a, b, mirrored));
    return found;
  }

  std::size_t candidates_of(std::size_t mark) const { return fitting_[mark].size(); }

  /// Returns the candidates of a mark, and of no other, within the capture of where a hypothesis
  /// has it.
  std::vector<std::size_t> near(const Hypothesis& h, std::size_t mark) const {
    std::vector<std::size_t> found;
    for (const std::size_t k : fitting_[mark]) {
      const bool is_others = h.candidates[mark] != k && h.takes(k);
      const double distance = (candidates_[k].p_B - h.at(drawing_[mark].p_W)).norm();
      if (!is_others && distance < capture_m()) found.push_back(k);
    }
    return found;
  }

  double capture_m() const { return kCapture_m + kCaptureShare * span(); }

 private:
  using Pair = std::pair<std::size_t, std::size_t>;

  double span() const {
    double longest = 0.0;
    for (const Fiducial& a : drawing_)
      for (const Fiducial& b : drawing_) longest = std::max(longest, (a.p_W - b.p_W).norm());
    return longest;
  }

  /// Returns pairs of marks, the farthest apart first. With all marks in view the first would do;
  /// the others find the work of which one mark is missing.
  std::vector<Pair> seed_pairs() const {
    constexpr std::size_t kMostPairs = 6;
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < drawing_.size(); ++i)
      for (std::size_t j = i + 1; j < drawing_.size(); ++j) pairs.emplace_back(i, j);
    const auto length = [&](const Pair& pair) {
      return (drawing_[pair.first].p_W - drawing_[pair.second].p_W).norm();
    };
    std::sort(pairs.begin(), pairs.end(),
              [&](const Pair& a, const Pair& b) { return length(a) > length(b); });
    pairs.resize(std::min(pairs.size(), kMostPairs));
    return pairs;
  }

  std::optional<Hypothesis> hypothesis(std::size_t i, std::size_t j, std::size_t a, std::size_t b,
                                       bool mirrored) const {
    const Eigen::Vector2d flip(1.0, mirrored ? -1.0 : 1.0);
    const Eigen::Vector2d drawn = flip.asDiagonal() * (drawing_[j].p_W - drawing_[i].p_W);
    const Eigen::Vector2d seen = candidates_[b].p_B - candidates_[a].p_B;
    if (std::abs(drawn.norm() - seen.norm()) > kCapture_m + kCaptureShare * drawn.norm())
      return std::nullopt;
    Hypothesis h;
    h.A = rotation2d(std::atan2(cross2d(drawn, seen), drawn.dot(seen))) * flip.asDiagonal();
    h.t = 0.5 * (candidates_[a].p_B + candidates_[b].p_B) -
          h.A * (0.5 * (drawing_[i].p_W + drawing_[j].p_W));
    if (place_ && !is_near(h)) return std::nullopt;
    take_candidates(h);
    return h;
  }

  bool is_near(const Hypothesis& h) const {
    constexpr double kTurn = 30.0 * kDegree;
    if ((h.t - place_->X_BW.p).norm() > place_->within_m) return false;
    const double turn = std::atan2(h.A(1, 0), h.A(0, 0));
    return place_->any_turn || std::abs(wrap_angle(turn - place_->X_BW.phi)) < kTurn;
  }

  void take_candidates(Hypothesis& h) const {
    h.candidates.assign(drawing_.size(), kNone);
    for (std::size_t i = 0; i < drawing_.size(); ++i) {
      double nearest = capture_m();
      for (const std::size_t k : fitting_[i]) {
        const double distance = (candidates_[k].p_B - h.at(drawing_[i].p_W)).norm();
        if (h.takes(k) || distance >= nearest) continue;
        nearest = distance;
        h.candidates[i] = k;
      }
      if (h.candidates[i] == kNone) continue;
      ++h.found;
      h.square_m2 += nearest * nearest;
    }
  }

  /// Adds a hypothesis unless it has fewer marks than those that are known; one of the same pose
  /// is replaced where it fits worse.
  void add(std::vector<Hypothesis>& found, const std::optional<Hypothesis>& h) const {
    if (!h || (!found.empty() && h->found < found.front().found)) return;
    if (!found.empty() && h->found > found.front().found) found.clear();
    for (Hypothesis& other : found) {
      if (!is_same(other, *h)) continue;
      if (h->square_m2 < other.square_m2) other = *h;
      return;
    }
    found.push_back(*h);
  }

  bool is_same(const Hypothesis& a, const Hypothesis& b) const {
    return std::all_of(drawing_.begin(), drawing_.end(), [&](const Fiducial& mark) {
      return (a.at(mark.p_W) - b.at(mark.p_W)).norm() < kSamePose_m + kCaptureShare * span();
    });
  }

  const std::vector<Fiducial>& drawing_;
  const std::vector<MarkCandidate>& candidates_;
  const std::optional<WorkPlace>& place_;
  std::vector<std::vector<std::size_t>> fitting_;  ///< candidates of each mark
};

/// Says how many candidates there are of each kind of mark that the drawing has.
std::string counts_text(const std::vector<Fiducial>& drawing,
                        const std::vector<MarkCandidate>& candidates) {
  std::string text;
  for (const auto& kind : kFiducialKinds) {
    const auto wanted = std::count_if(drawing.begin(), drawing.end(), [&](const Fiducial& mark) {
      return mark.kind == kind.value;
    });
    if (wanted == 0) continue;
    const auto seen = std::count_if(candidates.begin(), candidates.end(),
                                    [&](const MarkCandidate& c) { return c.kind == kind.value; });
    text += fmt::format("{}{} seen of about the size of the drawing's {} marks {}",
                        text.empty() ? "" : ", ", seen, wanted, kind.name);
  }
  return text;
}

[[noreturn]] void refuse_missing(const std::vector<Fiducial>& drawing, const Hypothesis& best) {
  std::string text;
  for (std::size_t i = 0; i < drawing.size(); ++i)
    if (best.candidates[i] == kNone)
      text +=
          fmt::format("{}{} is not seen where the other {} put it, at {}", text.empty() ? "" : "; ",
                      drawing[i].id, best.found, place_mm(best.at(drawing[i].p_W)));
  throw WorkError({text,
                   "uncover it and clean it, or leave its row out of the drawing if it is not "
                   "there; a drawing of another work may fit by chance; where several works lie, "
                   "--near picks one",
                   "", Cause::kInsufficient});
}

/// Refuses a further place of the drawing that lacks a mark: several works, of which one is hidden
/// in part, are not one.
void refuse_incomplete(const std::vector<Fiducial>& drawing,
                       const std::vector<MarkCandidate>& candidates,
                       const std::vector<Hypothesis>& complete) {
  std::vector<MarkCandidate> left;
  for (std::size_t k = 0; k < candidates.size(); ++k)
    if (std::none_of(complete.begin(), complete.end(),
                     [k](const Hypothesis& h) { return h.takes(k); }))
      left.push_back(candidates[k]);
  const std::optional<WorkPlace> anywhere;
  const std::vector<Hypothesis> others = Matcher(drawing, left, anywhere).best(false);
  if (!others.empty() && others.front().found > 2) refuse_missing(drawing, others.front());
}

void refuse_doubled(const Matcher& matcher, const std::vector<Fiducial>& drawing,
                    const std::vector<MarkCandidate>& candidates, const Hypothesis& h) {
  for (std::size_t i = 0; i < drawing.size(); ++i) {
    const std::vector<std::size_t> near = matcher.near(h, i);
    if (near.size() < 2) continue;
    throw WorkError(
        {fmt::format("two things look like {}: one at {}, one at {}", drawing[i].id,
                     place_mm(candidates[near[0]].p_B), place_mm(candidates[near[1]].p_B)),
         "cover the one that is not the mark, such as a reflection", "", Cause::kInsufficient});
  }
}

}  // namespace

std::vector<Constellation> match_constellation(const std::vector<Fiducial>& drawing,
                                               const std::vector<MarkCandidate>& candidates,
                                               const std::optional<WorkPlace>& place) {
  const Matcher matcher(drawing, candidates, place);
  const std::vector<Hypothesis> found = matcher.best(false);
  const std::size_t seen = found.empty() ? 0 : found.front().found;
  if (seen < drawing.size() && drawing.size() > 2) {
    const std::vector<Hypothesis> mirrored = matcher.best(true);
    if (!mirrored.empty() && mirrored.front().found > std::max<std::size_t>(seen, 2))
      throw WorkError({fmt::format("{} of the {} marks fit the drawing mirrored, and only {} as "
                                   "it is",
                                   mirrored.front().found, drawing.size(), seen),
                       "change the sign of the drawing's x or y, which point right and up, seen "
                       "from above, or turn the work over",
                       "", Cause::kContradiction});
  }
  // Two of several marks lie anywhere by chance.
  if (seen < std::min<std::size_t>(drawing.size(), 3)) {
    std::string unlike;
    for (std::size_t i = 0; i < drawing.size(); ++i)
      if (matcher.candidates_of(i) == 0) unlike += (unlike.empty() ? "" : ", ") + drawing[i].id;
    throw WorkError(
        {fmt::format("the drawing is found nowhere{}: {}{}", place ? " near the given place" : "",
                     counts_text(drawing, candidates),
                     unlike.empty() ? "" : "; none is like " + unlike),
         "compare the drawing's distances, kinds and sizes with the work, see that nothing hides "
         "its marks, and expose the picture so that they stand out",
         "", Cause::kInsufficient});
  }
  if (seen < drawing.size()) refuse_missing(drawing, found.front());
  std::vector<Constellation> places;
  for (const Hypothesis& h : found) {
    refuse_doubled(matcher, drawing, candidates, h);
    Constellation constellation;
    constellation.X_BW.linear() = h.A;
    constellation.X_BW.translation() = h.t;
    constellation.candidates = h.candidates;
    places.push_back(std::move(constellation));
  }
  if (!place) refuse_incomplete(drawing, candidates, found);
  return places;
}

}  // namespace planar
