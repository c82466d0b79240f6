#include "planar_servo/calibration/tracker_registration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/rigid_fit.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

// Residuals above this share of the monuments' spread mean that the cell file has them elsewhere.
constexpr double kMaxResidualShare = 1e-2;

std::map<std::string, std::vector<MonumentReading>> sort_readings(
    const std::vector<Monument>& monuments, const std::vector<MonumentReading>& readings) {
  Faults faults;
  std::map<std::string, std::vector<MonumentReading>> by_id;
  for (const Monument& monument : monuments) {
    if (!by_id.emplace(monument.id, std::vector<MonumentReading>()).second) {
      faults.add("datum: monument '" + monument.id + "' is named twice");
    }
    if (!monument.p_B.allFinite()) {
      faults.add("datum: monument '" + monument.id + "' has a coordinate that is not finite");
    }
  }
  for (const MonumentReading& reading : readings) {
    const auto known = by_id.find(reading.id);
    if (known == by_id.end()) {
      faults.add("datum: there is a reading of '" + reading.id +
                 "', which is no monument of the cell");
    } else if (!reading.p_L.allFinite()) {
      faults.add("datum: a reading of '" + reading.id + "' is not finite");
    } else {
      known->second.push_back(reading);
    }
  }
  faults.throw_if_any();
  return by_id;
}

void require_fit(const DatumRegistration& datum, const Eigen::Matrix3Xd& p_B) {
  const double spread =
      std::sqrt((p_B.colwise() - p_B.rowwise().mean()).colwise().squaredNorm().mean());
  if (datum.rms <= kMaxResidualShare * spread) return;
  throw InputError(
      fmt::format("datum: the readings do not fit the monuments' places, residual {:.3f} mm rms; "
                  "check the ids for an exchange, the unit of the readings and the coordinates in "
                  "the cell file",
                  datum.rms / kMillimetre));
}

DatumRegistration registration_of(const std::vector<MonumentSight>& sights) {
  DatumRegistration result;
  const auto n = static_cast<Eigen::Index>(sights.size());
  Eigen::Matrix3Xd p_B(3, n), p_L(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    p_B.col(i) = sights[static_cast<std::size_t>(i)].p_known;
    p_L.col(i) = sights[static_cast<std::size_t>(i)].p_read;
  }
  result.X_BL = fit_rigid_3d(p_B, p_L);
  for (Eigen::Index i = 0; i < n; ++i) {
    const MonumentSight& sight = sights[static_cast<std::size_t>(i)];
    const Eigen::Vector3d residual = result.X_BL * Eigen::Vector3d(p_L.col(i)) - p_B.col(i);
    result.residuals.push_back({sight.id, sight.readings, residual});
    result.rms += residual.squaredNorm() / static_cast<double>(n);
  }
  result.rms = std::sqrt(result.rms);
  require_fit(result, p_B);
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
  if (sights.size() < 3) {
    throw InputError("datum: the tracker has read " + std::to_string(sights.size()) +
                     " of the cell's monuments; at least 3 that are not on one line are needed");
  }
  const MonumentVerdict verdict = check_monuments(sights);
  std::optional<std::string> left_out;
  if (verdict.moved) {
    left_out = sights[*verdict.moved].id;
    sights.erase(sights.begin() + static_cast<std::ptrdiff_t>(*verdict.moved));
  }
  DatumRegistration result = registration_of(sights);
  if (verdict.refused) throw InputError(verdict.doubt.text());
  result.left_out = left_out;
  result.doubt = verdict.doubt;
  return result;
}

}  // namespace planar
