#include "planar_servo/learn/field/arm/arm_model.h"

#include <cmath>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Unknowns that are not estimated stay where they are.
constexpr double kFixed = 1e-9;
constexpr Eigen::Index kLinksAndZeros = 5;

/// Returns the offsets of reflector, lamp 1 and lamp 2 from the end point in the tool's frame.
Eigen::Matrix<double, 2, 3> tool_offsets(const Eigen::VectorXd& x, Eigen::Index tool) {
  const Eigen::Vector2d half(0.5 * x[tool], 0.0), p_TP = x.segment<2>(tool + 1);
  Eigen::Matrix<double, 2, 3> offsets;
  offsets << x.segment<2>(tool + 3), -p_TP - half, -p_TP + half;
  return offsets;
}

/// Returns d(where the tracker reads a point) / d(its terms), with links in directions psi.
Eigen::Matrix<double, 2, 10> tracker_rows(const Eigen::Vector2d& p, double reach,
                                          const Eigen::Vector3d& psi) {
  const Eigen::Vector2d q = p / reach;
  Eigen::Matrix<double, 2, 10> rows;
  rows.leftCols<6>() << 1.0, 0.0, -q.y(), q.x(), 0.0, q.y(), 0.0, 1.0, q.x(), 0.0, q.y(), q.x();
  rows.rightCols<4>() << rotation2d(psi[0]), rotation2d(psi[1]);
  return rows;
}

ArmForm form_of(const ArmNominal& nominal, const ArmModelSize& size) {
  return {PlanarArm(nominal.geometry).sense(),
          nominal.joints_per_motor,
          nominal.gear_ratios,
          size.harmonics,
          size.ripples,
          size.posture};
}

constexpr Eigen::Index kUnknowns = 9;  // the leans, a height, and sag with |P|^2 and |P|^4
/// No tracker reads heights better, metres.
constexpr double kLeastNoise = 1e-8;

AxisLeans as_built(double above_m) {
  AxisLeans leans;
  // Joint 1 stands upright on its base to about 0.02 deg; the bores of a link are parallel to
  // 0.01 mm over 100 mm at worst, to a tenth of that where one clamping made them.
  leans.sigma.head<2>().setConstant(0.02 * kDegree * above_m);
  leans.sigma.tail<4>().setConstant(1e-4 * above_m);
  return leans;
}

/// Returns d(height of the reflector) / d(unknowns).
Eigen::Matrix<double, 1, kUnknowns> height_row(const ArmNominal& nominal, const PoseSample& sample,
                                               double above_m) {
  const double sense = PlanarArm(nominal.geometry).sense();
  const Eigen::Vector3d psi = sense * nominal.joints_per_motor * sample.motors;
  const Eigen::Matrix2d link1 = rotation2d(psi[0]), link2 = rotation2d(psi[1]);
  const Eigen::Vector2d elbow = nominal.geometry.link_lengths_m[0] * link1.col(0);
  const Eigen::Vector2d tip = elbow + nominal.geometry.link_lengths_m[1] * link2.col(0);
  const Eigen::Vector2d p = *sample.reflector_B;
  const double r2 = tip.squaredNorm();
  Eigen::Matrix<double, 1, kUnknowns> row;
  row << -p.transpose() / above_m, -(p - elbow).transpose() * link1 / above_m,
      -(p - tip).transpose() * link2 / above_m, 1.0, r2, r2 * r2;
  return row;
}

/// What heights tell of the unknowns, given a prior. The evidence lacks what the prior does not
/// change.
struct Told {
  Eigen::VectorXd mean, variance;
  double log_evidence{0.0};
};

/// `weights` are the heights' inverse variances.
std::optional<Told> told_by(const Eigen::MatrixXd& A, const Eigen::VectorXd& z,
                            const Eigen::VectorXd& weights, const Eigen::VectorXd& prior) {
  const Eigen::MatrixXd weighed = weights.asDiagonal() * A;
  Eigen::MatrixXd H = A.transpose() * weighed;
  H.diagonal() += prior.cwiseAbs2().cwiseInverse();
  const auto L = lower_factor(H);
  if (!L) return std::nullopt;
  const Eigen::MatrixXd inverse = inverse_of_lower(*L);
  Told told;
  told.variance = inverse.colwise().squaredNorm();
  told.mean = inverse.transpose() * (inverse * (weighed.transpose() * z));
  told.log_evidence = -0.5 * (z - A * told.mean).dot(weights.cwiseProduct(z)) -
                      (L->diagonal().array() * prior.array()).log().sum();
  return told;
}

/// Returns the weights of heights as what a fit leaves of them tells their noise, and which are
/// outliers; empty where it tells none, as of heights that nobody has read.
std::optional<Eigen::VectorXd> weights_of(const Eigen::MatrixXd& A, const Eigen::VectorXd& z,
                                          const Eigen::VectorXd& prior) {
  constexpr double kFirstNoise = 1e-5, kOutlier = 4.0;
  Eigen::VectorXd weights = Eigen::VectorXd::Constant(z.size(), std::pow(kFirstNoise, -2));
  for (int round = 0; round < 3; ++round) {
    const auto told = told_by(A, z, weights, prior);
    if (!told) return std::nullopt;
    const double used = (weights.array() > 0.0).cast<double>().sum(),
                 fitted = (1.0 - (told->variance.array() / prior.array().square())).sum();
    const Eigen::ArrayXd far = (z - A * told->mean).array().abs();
    const double noise = kNormalPerMad * median({far.begin(), far.end()}) *
                         std::sqrt(used / std::max(1.0, used - fitted));
    if (!(noise > kLeastNoise)) return std::nullopt;
    weights = (far < kOutlier * noise).cast<double>() / (noise * noise);
  }
  return weights;
}

/// Returns the mean of the cases and its deviation, each case as likely as the heights make it.
AxisLeans mean_of(const std::vector<Told>& cases) {
  double total = 0.0;
  Eigen::Matrix<double, 6, 1> mean = Eigen::Matrix<double, 6, 1>::Zero(), square = mean;
  for (const Told& told : cases) {
    const double weight = std::exp(told.log_evidence - cases.front().log_evidence);
    total += weight;
    mean += weight * told.mean.head<6>();
    square += weight * (told.variance.head<6>() + told.mean.head<6>().cwiseAbs2());
  }
  mean /= total;
  return {mean, (square / total - mean.cwiseAbs2()).cwiseSqrt()};
}

}  // namespace

Eigen::RowVectorXd HeightForm::at(const Eigen::Vector2d& tip) const {
  const double r2 = tip.squaredNorm();
  Eigen::RowVectorXd row(terms());
  row.head<3>() << -r2, -r2 * (r2 / (reach * reach) - 0.5), 0.0;
  row.tail(wave.centers.cols()) = wave.gaussians(tip);
  return row;
}

ArmModel::ArmModel(const ArmNominal& nominal, const ArmModelSize& size)
    : nominal_(nominal),
      size_(size),
      form_(form_of(nominal, size)),
      height_{size.wave, nominal.geometry.link_lengths_m.sum()} {}

ArmModel::Layout ArmModel::layout() const {
  Layout at{};
  at.warming = form_.terms();
  at.wander = at.warming + (size_.warms ? kWarmingTerms : 0);
  at.height = at.wander + 2 * size_.wander.centers.cols();
  at.tool = at.height + height_.terms();
  at.tracker = at.tool + kToolTerms;
  return at;
}

Eigen::VectorXd ArmModel::nominal() const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(terms());
  x.head<2>() = nominal_.geometry.link_lengths_m;
  x.segment<kToolTerms>(layout().tool) << nominal_.separation, nominal_.tool.p_TP,
      nominal_.tool.p_TS.head<2>();
  x.segment<2>(layout().tracker) = nominal_.leans.shift.head<2>();
  x.tail<4>() = nominal_.leans.shift.tail<4>();
  return x;
}

Eigen::VectorXd ArmModel::prior_sigma() const {
  // A strain-wave gear errs by up to 1.5', belts and planetary gears by up to 5', once or twice per
  // turn of the motor; axes run out by 2 to 10 um.
  constexpr double kRipple = 1e-3, kRunout = 10e-6;
  // Motors warm links by 3 to 15 K in an hour: aluminium grows by up to 350 um/m.
  constexpr double kGrowth = 1.5e-4, kZeroShift = 5e-5;
  Eigen::VectorXd sigma = Eigen::VectorXd::Ones(terms());
  const Layout at = layout();
  sigma.head<kLinksAndZeros>() << 2e-3, 2e-3, nominal_.zero1_sigma, 0.02, 0.02;
  for (int wave = 0; wave < form_.waves(); ++wave)
    sigma.segment<6>(ArmForm::kFirstWave + Eigen::Index{6} * wave)
        .setConstant(wave < size_.harmonics ? 2e-3 / (wave + 1) : kRipple);
  sigma.segment<2>(form_.runout()).setConstant(kRunout);
  if (size_.warms)
    sigma.segment<kWarmingTerms>(at.warming) << kGrowth, kGrowth, kZeroShift, kZeroShift,
        kZeroShift, kGrowth, kGrowth, kZeroShift, kZeroShift, kZeroShift;
  const double height = size_.height ? 2e-3 : kFixed;
  sigma.segment<3>(at.height) << height, height, size_.height ? 1e-4 : kFixed;
  sigma.segment<kToolTerms>(at.tool) << 0.3e-3, nominal_.end_point_sigma, nominal_.reflector_sigma,
      nominal_.reflector_sigma;
  const Eigen::Array<double, 6, 1> lean = nominal_.leans.sigma.array() + kFixed;
  const double turn = nominal_.registration_turn * height_.reach;
  sigma.segment<6>(at.tracker) << nominal_.registration_shift, nominal_.registration_shift,
      std::hypot(turn, nominal_.tracker_bias), nominal_.tracker_bias, nominal_.tracker_bias,
      nominal_.tracker_bias;
  for (int i = 0; i < 2; ++i) sigma[at.tracker + i] = std::hypot(sigma[at.tracker + i], lean[i]);
  sigma.tail<4>() = lean.tail<4>();
  return sigma;
}

Eigen::VectorXd ArmModel::arm_at(double t_h, const Eigen::VectorXd& x) const {
  Eigen::VectorXd arm = x.head(form_.terms());
  if (!size_.warms) return arm;
  const auto slow = x.segment<kWarmingTerms>(layout().warming);
  Eigen::VectorXd change = t_h * (slow.head<kLinksAndZeros>() + t_h * slow.tail<kLinksAndZeros>());
  change.head<2>().array() *= x.head<2>().array();
  arm.head<kLinksAndZeros>() += change;
  return arm;
}

Eigen::Vector2d ArmModel::tracker_error(const Eigen::Vector3d& motors, const Eigen::Vector2d& p,
                                        const Eigen::VectorXd& x) const {
  return tracker_rows(p, height_.reach, form_.sense * form_.joints_per_motor * motors) *
         x.tail<kTrackerTerms>();
}

ToolPoints ArmModel::at(const PosedAt& pose, const Eigen::VectorXd& x) const {
  const Layout at = layout();
  ToolPoints seen;
  seen.tip = form_.tip(pose.motors, arm_at(pose.t_h, x));
  const Eigen::Index nw = size_.wander.centers.cols();
  seen.tip.p +=
      (size_.wander.gaussians({pose.t_h, 0.0}) * x.segment(at.wander, 2 * nw).reshaped(nw, 2))
          .transpose();
  seen.points = (rotation2d(seen.tip.phi) * tool_offsets(x, at.tool)).colwise() + seen.tip.p;
  seen.points.col(0) += tracker_error(pose.motors, seen.points.col(0), x);
  const double middle = height_.at(seen.tip.p).dot(x.segment(at.height, height_.terms()));
  for (int lamp = 1; lamp <= 2; ++lamp) {
    const double height = middle + (lamp == 1 ? -0.5 : 0.5) * x[at.height + 2];
    seen.points.col(lamp) +=
        height / nominal_.p_camera_B.z() * (seen.points.col(lamp) - nominal_.p_camera_B.head<2>());
  }
  return seen;
}

ArmModel::Jacobian ArmModel::jacobian(const PosedAt& pose, const Eigen::VectorXd& x) const {
  const Layout at = layout();
  const ToolPoints now = this->at(pose, x);
  const Eigen::Matrix<double, 2, 3> offsets = tool_offsets(x, at.tool);
  const Eigen::Matrix2d R = rotation2d(now.tip.phi);
  const ArmForm::Jacobian by_arm = form_.jacobian(pose.motors, arm_at(pose.t_h, x));
  const Eigen::RowVectorXd by_height = height_.at(now.tip.p);
  const Eigen::RowVectorXd by_time = size_.wander.gaussians({pose.t_h, 0.0});
  Jacobian J = Jacobian::Zero(6, terms());
  for (Eigen::Index point = 0; point < 3; ++point) {
    auto rows = J.middleRows<2>(2 * point);
    const Eigen::Vector2d arm = R * offsets.col(point), turned(-arm.y(), arm.x());
    rows.leftCols(form_.terms()) = by_arm.topRows<2>() + turned * by_arm.row(2);
    if (size_.warms) {
      Eigen::Matrix<double, 2, kLinksAndZeros> slow = rows.leftCols<kLinksAndZeros>();
      slow.leftCols<2>() *= x.head<2>().asDiagonal();
      rows.middleCols<kLinksAndZeros>(at.warming) = pose.t_h * slow;
      rows.middleCols<kLinksAndZeros>(at.warming + kLinksAndZeros) = pose.t_h * pose.t_h * slow;
    }
    rows.block(0, at.wander, 1, by_time.size()) = by_time;
    rows.block(1, at.wander + by_time.size(), 1, by_time.size()) = by_time;
    if (point == 0) {
      rows.middleCols<2>(at.tool + 3) = R;
      rows.rightCols<kTrackerTerms>() = tracker_rows(
          now.points.col(0), height_.reach, form_.sense * form_.joints_per_motor * pose.motors);
      continue;
    }
    // The height's own change with the other unknowns is of second order.
    const Eigen::Vector2d off =
        (now.points.col(point) - nominal_.p_camera_B.head<2>()) / nominal_.p_camera_B.z();
    const double side = point == 1 ? -0.5 : 0.5;
    rows.middleCols(at.height, height_.terms()) = off * by_height;
    rows.col(at.height + 2) = side * off;
    rows.col(at.tool) = side * R.col(0);
    rows.middleCols<2>(at.tool + 1) = -R;
  }
  return J;
}

AxisLeans axis_leans(const ArmNominal& nominal, const std::vector<PoseSample>& samples) {
  const double above_m = std::abs(nominal.tool.p_TS.z());
  AxisLeans built = as_built(above_m);
  std::vector<const PoseSample*> read;
  for (const PoseSample& sample : samples)
    if (sample.reflector_B && sample.reflector_z) read.push_back(&sample);
  const auto n = static_cast<Eigen::Index>(read.size());
  if (n < 2 * kUnknowns || above_m < kMillimetre) return built;
  Eigen::MatrixXd A(n, kUnknowns);
  Eigen::VectorXd z(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    A.row(i) = height_row(nominal, *read[static_cast<std::size_t>(i)], above_m);
    z[i] = *read[static_cast<std::size_t>(i)]->reflector_z;
  }
  // Nobody knows how well the links are bored: the heights weigh what each case would tell.
  constexpr std::array<double, 3> kShares{0.1, 0.3, 1.0};
  constexpr double kAnyHeight = 1.0;
  const auto prior_of = [&](double share) {
    Eigen::VectorXd prior = Eigen::VectorXd::Constant(kUnknowns, kAnyHeight);
    prior.head<6>() << built.sigma.head<2>(), share * built.sigma.tail<4>();
    return prior;
  };
  const auto weights = weights_of(A, z, prior_of(kShares.back()));
  if (!weights) return built;
  std::vector<Told> cases;
  for (const double share : kShares) {
    auto told = told_by(A, z, *weights, prior_of(share));
    if (!told) return built;
    cases.push_back(std::move(*told));
  }
  return mean_of(cases);
}

}  // namespace planar
