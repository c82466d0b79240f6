#include "planar_servo/calibration/tracker_registration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

using Monuments = std::vector<MonumentSight>;

constexpr char kReadAgain[] =
    "clean and read them again, look for one that was bumped, or correct `datum` in the cell file";

Monuments all_but(const Monuments& monuments, std::size_t left_out) {
  Monuments rest = monuments;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(left_out));
  return rest;
}

Eigen::Matrix3Xd columns_of(const Monuments& monuments, Eigen::Vector3d MonumentSight::*place) {
  Eigen::Matrix3Xd p(3, monuments.size());
  for (std::size_t i = 0; i < monuments.size(); ++i)
    p.col(static_cast<Eigen::Index>(i)) = monuments[i].*place;
  return p;
}

Pose rigid_pose(const Monuments& monuments) {
  return fit_rigid_3d(columns_of(monuments, &MonumentSight::p_known),
                      columns_of(monuments, &MonumentSight::p_read));
}

/// Returns how much longer the distance of two monuments was read than it is known to be, metres.
double side_error(const MonumentSight& a, const MonumentSight& b) {
  return (a.p_read - b.p_read).norm() - (a.p_known - b.p_known).norm();
}

/// Two monuments show but one length: a rigid fit halves its error between them.
double square_left(const Monuments& monuments) {
  if (monuments.size() == 2) return 0.5 * std::pow(side_error(monuments[0], monuments[1]), 2);
  const Pose X_BL = rigid_pose(monuments);
  double square = 0.0;
  for (const MonumentSight& m : monuments) square += (X_BL * m.p_read - m.p_known).squaredNorm();
  return square;
}

double sigma_of_one(const Monuments& monuments) {
  double sigma = 0.0;
  for (const MonumentSight& m : monuments) sigma = std::max(sigma, m.sigma);
  return sigma;
}

double sigma_of_mean(const Monuments& monuments) {
  double sigma = 0.0;
  for (const MonumentSight& m : monuments)
    sigma = std::max(sigma, m.sigma / std::sqrt(static_cast<double>(m.readings)));
  return sigma;
}

bool explains(double sigma, double square, std::size_t degrees) {
  return chi_square_tail(square / (sigma * sigma), static_cast<int>(degrees)) >= kFalseAlarm;
}

/// Returns whether noise of this size explains what a rigid fit leaves. Monuments on one line show
/// nothing.
bool fits(const Monuments& monuments, double sigma) {
  try {
    const std::size_t degrees = monuments.size() == 2 ? 1 : 3 * monuments.size() - 6;
    return explains(sigma, square_left(monuments), degrees);
  } catch (const InputError&) {
    return false;
  }
}

/// Returns how far a monument lies from its known position, by the others; zero when those lie on
/// one line.
Eigen::Vector3d offset_of(const Monuments& monuments, std::size_t i) {
  try {
    return rigid_pose(all_but(monuments, i)) * monuments[i].p_read - monuments[i].p_known;
  } catch (const InputError&) {
    return Eigen::Vector3d::Zero();
  }
}

std::string offset_text(const Monuments& monuments, std::size_t i, double sigma) {
  const Eigen::Vector3d offset = offset_of(monuments, i);
  return fmt::format(
      "'{}' lies {:.3f} mm from its place in the cell file, ({}) mm along x, y, z +- {:.3f}",
      monuments[i].id, mm(offset.norm()), fixed(offset / kMillimetre, 3, ", "), mm(sigma));
}

std::string worst_offset(const Monuments& monuments, double sigma) {
  std::size_t worst = 0;
  for (std::size_t i = 1; i < monuments.size(); ++i)
    if (offset_of(monuments, i).norm() > offset_of(monuments, worst).norm()) worst = i;
  return "by the others, " + offset_text(monuments, worst, sigma);
}

/// Returns the side whose length differs most from that in the cell file.
std::string worst_side(const Monuments& monuments, double sigma) {
  std::string text;
  double worst = -1.0;
  for (std::size_t i = 0; i < monuments.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double read = (monuments[i].p_read - monuments[k].p_read).norm();
      const double error = side_error(monuments[i], monuments[k]);
      if (std::abs(error) <= worst) continue;
      worst = std::abs(error);
      text = fmt::format(
          "'{}' and '{}' are {:.3f} mm apart, {:.3f} +- {:.3f} mm {} than in the cell file",
          monuments[k].id, monuments[i].id, mm(read), mm(worst), mm(std::sqrt(2.0) * sigma),
          error > 0.0 ? "more" : "less");
    }
  }
  return text;
}

/// Returns the monuments without each of which the others fit.
std::vector<std::size_t> suspects(const Monuments& monuments, double sigma) {
  std::vector<std::size_t> found;
  if (monuments.size() < 4) return found;
  for (std::size_t i = 0; i < monuments.size(); ++i)
    if (fits(all_but(monuments, i), sigma)) found.push_back(i);
  return found;
}

MonumentVerdict verdict(const Monuments& monuments, double sigma) {
  const std::vector<std::size_t> suspected = suspects(monuments, sigma);
  MonumentVerdict result;
  if (suspected.size() == 1) {
    result.moved = suspected.front();
    result.doubt.cause = Cause::kContradiction;
    result.doubt.fault = "datum: " + offset_text(monuments, suspected.front(), sigma) +
                         ", while the others fit; has it moved? " + kReadAgain;
    return result;
  }
  result.doubt = {
      fmt::format(
          "datum: a monument has moved, or is wrong in the cell file: {}; {} monuments do not show "
          "which one",
          monuments.size() <= 3 ? worst_side(monuments, sigma) : worst_offset(monuments, sigma),
          monuments.size()),
      kReadAgain, "", Cause::kContradiction};
  return result;
}

/// Returns the monuments that were read twice, at the beginning (p_known) and at the end (p_read).
Monuments read_twice(const Monuments& begin, const Monuments& end) {
  Monuments both;
  for (const MonumentSight& first : begin) {
    const auto last = std::find_if(end.begin(), end.end(),
                                   [&](const MonumentSight& m) { return m.id == first.id; });
    if (last == end.end()) continue;
    both.push_back({first.id, first.p_read, last->p_read, std::min(first.readings, last->readings),
                    std::sqrt(2.0) * std::max(first.sigma, last->sigma)});
  }
  return both;
}

Refusal doubt_of_drift(const Monuments& ends, double sigma) {
  const Eigen::Matrix3Xd shifts =
      columns_of(ends, &MonumentSight::p_read) - columns_of(ends, &MonumentSight::p_known);
  std::string sizes;
  for (const MonumentSight& m : ends)
    sizes += fmt::format("{}'{}' by {:.3f}", sizes.empty() ? "" : ", ", m.id,
                         mm((m.p_read - m.p_known).norm()));
  const std::string who =
      ends.size() == 1 ? "the tracker, the base or this monument moved"
      : fits(ends, sigma)
          ? fmt::format(
                "their distances have not changed, so the tracker or the base moved, by {:.3f} "
                "mm on average",
                mm(shifts.rowwise().mean().norm()))
          : "not all alike, so one of them moved";
  return {
      fmt::format("datum: between the beginning and the end of the recording the monuments moved "
                  "relative to the tracker: {} mm, +- {:.3f} per axis; {}",
                  sizes, mm(sigma), who),
      "record again with tracker and monuments at rest", "", Cause::kContradiction};
}

}  // namespace

MonumentVerdict check_monuments(const Monuments& monuments) {
  const double single = sigma_of_one(monuments);
  if (!(single > 0.0) || monuments.size() < 2) return {};
  if (!fits(monuments, single)) {
    MonumentVerdict result = verdict(monuments, single);
    result.refused = !result.moved;
    return result;
  }
  const double mean = sigma_of_mean(monuments);
  if (fits(monuments, mean)) return {};
  MonumentVerdict result = verdict(monuments, mean);
  result.moved.reset();
  return result;
}

MonumentVerdict check_drift(const Monuments& begin, const Monuments& end) {
  const Monuments ends = read_twice(begin, end);
  const double single = sigma_of_one(ends);
  if (ends.empty() || !(single > 0.0)) return {};
  double square = 0.0;
  for (const MonumentSight& m : ends) square += (m.p_read - m.p_known).squaredNorm();
  const double mean = sigma_of_mean(ends);
  if (explains(mean, square, 3 * ends.size())) return {};
  const bool refused = !explains(single, square, 3 * ends.size());
  return {std::nullopt, doubt_of_drift(ends, mean), refused};
}

namespace {

// Residuals above this share of the monuments' spread mean that the cell file has them elsewhere.
constexpr double kMaxResidualShare = 1e-2;

std::map<std::string, std::vector<MonumentReading>> sort_readings(
    const std::vector<Monument>& monuments, const std::vector<MonumentReading>& readings) {
  Faults faults;
  std::map<std::string, std::vector<MonumentReading>> by_id;
  for (const Monument& monument : monuments) {
    if (!by_id.emplace(monument.id, std::vector<MonumentReading>()).second)
      faults.add({"monument '" + monument.id + "' is named twice", "", "datum", Cause::kExists});
    if (!monument.p_B.allFinite())
      faults.add(
          {"monument '" + monument.id + "' has a coordinate that is not finite", "", "datum"});
  }
  for (const MonumentReading& reading : readings) {
    const auto known = by_id.find(reading.id);
    if (known == by_id.end()) {
      faults.add({"there is a reading of '" + reading.id + "', which is not a monument of the cell",
                  "", "datum"});
    } else if (!reading.p_L.allFinite()) {
      faults.add({"a reading of '" + reading.id + "' is not finite", "", "datum"});
    } else {
      known->second.push_back(reading);
    }
  }
  faults.throw_if_any();
  return by_id;
}

void require_fit(const DatumRegistration& datum, const Monuments& monuments) {
  const Eigen::Matrix3Xd p_B = columns_of(monuments, &MonumentSight::p_known);
  const double spread =
      std::sqrt((p_B.colwise() - p_B.rowwise().mean()).colwise().squaredNorm().mean());
  if (datum.rms <= kMaxResidualShare * spread) return;
  throw InputError(
      {fmt::format("the readings do not fit the monuments' positions, residual {:.3f} mm rms",
                   mm(datum.rms)),
       "check for exchanged ids, and check the unit of the readings and the coordinates in the "
       "cell file",
       "datum", Cause::kContradiction});
}

DatumRegistration registration_of(const Monuments& sights) {
  DatumRegistration result;
  result.X_BL = rigid_pose(sights);
  for (const MonumentSight& sight : sights) {
    const Eigen::Vector3d residual = result.X_BL * sight.p_read - sight.p_known;
    result.residuals.push_back({sight.id, sight.readings, residual});
    result.rms += residual.squaredNorm() / static_cast<double>(sights.size());
  }
  result.rms = std::sqrt(result.rms);
  require_fit(result, sights);
  return result;
}

}  // namespace

std::vector<MonumentSight> monument_sights(const std::vector<Monument>& monuments,
                                           const std::vector<MonumentReading>& readings) {
  const auto by_id = sort_readings(monuments, readings);
  std::vector<MonumentSight> sights;
  for (const Monument& monument : monuments) {
    const std::vector<MonumentReading>& own = by_id.at(monument.id);
    if (own.empty()) continue;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double sigma = 0.0;
    for (const MonumentReading& reading : own) {
      sum += reading.p_L;
      sigma = std::max(sigma, reading.sigma);
    }
    sights.push_back(
        {monument.id, monument.p_B, sum / static_cast<double>(own.size()), own.size(), sigma});
  }
  return sights;
}

DatumRegistration register_datum(const std::vector<Monument>& monuments,
                                 const std::vector<MonumentReading>& readings) {
  std::vector<MonumentSight> sights = monument_sights(monuments, readings);
  if (sights.size() < 3)
    throw InputError(
        {"the tracker has read " + std::to_string(sights.size()) + " of the cell's monuments",
         "at least 3 that are not on one line are needed", "datum", Cause::kInsufficient});
  const MonumentVerdict verdict = check_monuments(sights);
  std::optional<std::string> left_out;
  if (verdict.moved) {
    left_out = sights[*verdict.moved].id;
    sights.erase(sights.begin() + static_cast<std::ptrdiff_t>(*verdict.moved));
  }
  DatumRegistration result = registration_of(sights);
  if (verdict.refused) throw InputError(verdict.doubt);
  result.left_out = left_out;
  result.doubt = verdict.doubt;
  return result;
}

}  // namespace planar
