#include "planar_servo/field/joint_fit.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "planar_servo/core/numerics/decompositions.h"

namespace planar {
namespace {

constexpr int kMostSteps = 8;
/// Steps smaller than this share of the prior deviations end the iteration.
constexpr double kSmallStep = 1e-4;
/// Prior deviation of each term of the field's quadratic, metres.
constexpr double kQuadraticSigma = 1e-3;
/// Prior deviation of the camera's drift along an axis, metres an hour.
constexpr double kDriftSigma = 30e-6;

constexpr int kRows = 6;  // of a pose: reflector, lamp 1, lamp 2
using PoseRows = Eigen::Matrix<double, kRows, 1>;
using PoseWeight = Eigen::Matrix<double, kRows, kRows>;

/// How the rows of one pose are weighed: rows of `whiten` times its residuals have unit variance.
struct PoseNoise {
  PoseWeight whiten{PoseWeight::Zero()};
  double log_determinant{0.0};  ///< of the covariance
};

PoseNoise noise_of(const PoseSample& sample, const JointPriors& priors,
                   const Eigen::Matrix<double, 2, 3>& offsets) {
  const Eigen::Index first = sample.reflector_B ? 0 : 2, n = kRows - first;
  PoseRows variance;
  const double lamp = priors.lamp_factor * sample.sigma_lamp;
  variance.head<2>().setConstant(sample.sigma_reflector * sample.sigma_reflector);
  variance.tail<4>().setConstant(lamp * lamp);
  Eigen::Matrix<double, kRows, 3> shared;  // a shift of the end point, and a turn about it
  for (Eigen::Index point = 0; point < 3; ++point)
    shared.middleRows<2>(2 * point) << priors.arm_sigma, 0.0,
        -priors.tool_sigma * offsets(1, point), 0.0, priors.arm_sigma,
        priors.tool_sigma * offsets(0, point);
  PoseWeight covariance = shared * shared.transpose();
  covariance.diagonal() += variance;
  const Eigen::MatrixXd L = *lower_factor(covariance.bottomRightCorner(n, n));
  PoseNoise noise;
  noise.whiten.bottomRightCorner(n, n) =
      L.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(n, n));
  noise.log_determinant = 2.0 * L.diagonal().array().log().sum();
  return noise;
}

/// The equations of one fit, built up pose by pose.
class Equations {
 public:
  Equations(const ArmModel& model, const JointPriors& priors,
            const std::vector<PoseSample>& samples, FieldBasis basis, const LaidDots& board)
      : model_(model),
        samples_(samples),
        basis_(std::move(basis)),
        board_(lay_information(board, basis_, priors.dot_factor)),
        kernel_(basis_.kernel_matrix()),
        priors_(priors),
        nominal_(model.nominal()),
        sigma_(model.prior_sigma()) {
    field_rows();
  }

  /// Returns whether the steps converge.
  bool solve() {
    x_ = nominal_;
    for (int step = 0; step < kMostSteps; ++step) {
      linearize(x_);
      auto L = lower_factor(H_);
      if (!L) return false;
      L_ = std::move(*L);
      half_ = L_.triangularView<Eigen::Lower>().solve(right_);
      solution_ = L_.transpose().triangularView<Eigen::Upper>().solve(half_);
      const Eigen::VectorXd dx = solution_.tail(model_.terms());
      x_ += dx;
      if ((dx.array() / sigma_.array()).abs().maxCoeff() < kSmallStep) return true;
    }
    return false;
  }

  JointFit result() const {
    JointFit fit;
    const Eigen::Index nb = basis_.terms(), n = terms();
    fit.basis = basis_;
    const Eigen::MatrixX2d of_field = solution_.head(field_terms()).reshaped(nb + 1, 2);
    fit.weights = of_field.topRows(nb);
    fit.drift_m_per_h = of_field.row(nb);
    fit.arm = x_;
    const Eigen::MatrixXd inverse =
        L_.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(n, n));
    fit.covariance = inverse.transpose() * inverse;
    fit.log_likelihood = log_likelihood();
    fit.chi2 = chi2(inverse);
    return fit;
  }

  /// Returns log p(samples) but for a constant that depends on the number of samples only.
  double log_likelihood() const {
    const Eigen::MatrixXd kernel_factor = *lower_factor(kernel_);
    const double kernel = 2.0 * kernel_factor.diagonal().array().log().sum() -
                          2.0 * static_cast<double>(kernel_.rows()) * std::log(priors_.field_sigma);
    const double prior = 2.0 * sigma_.array().log().sum() +
                         4.0 * FieldBasis::kQuadratic * std::log(kQuadraticSigma) +
                         4.0 * std::log(kDriftSigma) - 2.0 * kernel;
    const double posterior = 2.0 * L_.diagonal().array().log().sum();
    double noise = board_.log_determinant;
    for (const PoseNoise& of_pose : noise_) noise += of_pose.log_determinant;
    return -0.5 * (squares_ - half_.squaredNorm() + noise + posterior + prior);
  }

 private:
  Eigen::Index field_terms() const { return 2 * (basis_.terms() + 1); }
  Eigen::Index terms() const { return field_terms() + model_.terms(); }

  /// Whitens the rows of the field, which no step changes, and adds its prior and the board.
  void field_rows() {
    const auto n = static_cast<Eigen::Index>(samples_.size());
    F_ = Eigen::MatrixXd::Zero(kRows * n, field_terms());
    const Eigen::Index nb = basis_.terms();
    for (Eigen::Index i = 0; i < n; ++i) {
      const PoseSample& sample = samples_[static_cast<std::size_t>(i)];
      const ToolPoints seen = model_.at(sample.motors, nominal_);
      noise_.push_back(noise_of(sample, priors_, seen.points.colwise() - seen.tip.p));
      Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(kRows, field_terms());
      for (int lamp = 0; lamp < 2; ++lamp) {
        const Eigen::RowVectorXd b = basis_.at(sample.lamps_B[static_cast<std::size_t>(lamp)]);
        rows.row(2 + 2 * lamp).head(nb + 1) << b, sample.t_h;
        rows.row(3 + 2 * lamp).tail(nb + 1) << b, sample.t_h;
      }
      F_.middleRows<kRows>(kRows * i).noalias() = noise_.back().whiten * rows;
    }
    H0_ = Eigen::MatrixXd::Zero(terms(), terms());
    if (n > 0)  // Eigen divides by the number of rows
      H0_.topLeftCorner(field_terms(), field_terms())
          .selfadjointView<Eigen::Lower>()
          .rankUpdate(F_.transpose());
    const Eigen::Index nc = basis_.centers.cols();
    const double field_variance = priors_.field_sigma * priors_.field_sigma;
    for (const Eigen::Index first : {Eigen::Index{0}, nb + 1}) {
      H0_.block(first, first, nc, nc) += kernel_ / field_variance;
      H0_.diagonal().segment<FieldBasis::kQuadratic>(first + nc).array() +=
          1.0 / (kQuadraticSigma * kQuadraticSigma);
      H0_(first + nb, first + nb) += 1.0 / (kDriftSigma * kDriftSigma);
    }
    H0_.diagonal().tail(model_.terms()).array() += sigma_.array().square().inverse();
    for (const Eigen::Index row : {0, 1})
      for (const Eigen::Index column : {0, 1})
        H0_.block(row * (nb + 1), column * (nb + 1), nb, nb) +=
            board_.H.block(row * nb, column * nb, nb, nb);
  }

  /// The whitened rows of the arm about x, and their residuals but for the field.
  struct ArmRows {
    Eigen::MatrixXd J;
    Eigen::VectorXd z;
  };

  ArmRows arm_rows(const Eigen::VectorXd& x) const {
    ArmRows rows{Eigen::MatrixXd(F_.rows(), model_.terms()), Eigen::VectorXd(F_.rows())};
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(kRows * i);
      const PoseSample& sample = samples_[i];
      rows.J.middleRows<kRows>(row).noalias() =
          noise_[i].whiten * model_.jacobian(sample.motors, x);
      rows.z.segment<kRows>(row) = noise_[i].whiten * residual(sample, x);
    }
    return rows;
  }

  /// A sample pulls the fit towards itself; its residual's covariance is what that leaves of its
  /// noise, I - A (A^T A)^-1 A^T. `inverse` is that of the normal equations' lower factor.
  std::vector<double> chi2(const Eigen::MatrixXd& inverse) const {
    const ArmRows rows = arm_rows(x_);
    Eigen::MatrixXd A(F_.rows(), terms());
    A << F_, rows.J;
    const Eigen::VectorXd left = rows.z - F_ * solution_.head(field_terms());
    const Eigen::MatrixXd pull = inverse.triangularView<Eigen::Lower>() * A.transpose();
    std::vector<double> all;
    for (Eigen::Index row = 0; row < F_.rows(); row += kRows) {
      const auto of_pose = pull.middleCols<kRows>(row);
      const PoseWeight covariance = PoseWeight::Identity() - of_pose.transpose() * of_pose;
      const PoseRows residual = left.segment<kRows>(row);
      all.push_back(residual.dot(covariance.ldlt().solve(residual)));
    }
    return all;
  }

  void linearize(const Eigen::VectorXd& x) {
    const Eigen::Index nf = field_terms(), na = model_.terms();
    const auto [J, z] = arm_rows(x);
    const Eigen::VectorXd off = (nominal_ - x).cwiseQuotient(sigma_);
    H_ = H0_;
    if (!samples_.empty()) {
      H_.bottomLeftCorner(na, nf).noalias() += J.transpose() * F_;
      H_.bottomRightCorner(na, na).selfadjointView<Eigen::Lower>().rankUpdate(J.transpose());
    }
    right_.resize(terms());
    right_ << F_.transpose() * z, J.transpose() * z + off.cwiseQuotient(sigma_);
    const Eigen::Index nb = basis_.terms();
    right_.head(nb) += board_.right.head(nb);
    right_.segment(nb + 1, nb) += board_.right.tail(nb);
    squares_ = z.squaredNorm() + off.squaredNorm() + board_.squares;
  }

  PoseRows residual(const PoseSample& sample, const Eigen::VectorXd& x) const {
    const ToolPoints at = model_.at(sample.motors, x);
    PoseRows z;
    z << sample.reflector_B.value_or(at.points.col(0)) - at.points.col(0),
        sample.lamps_B[0] - at.points.col(1), sample.lamps_B[1] - at.points.col(2);
    return z;
  }

  const ArmModel& model_;
  const std::vector<PoseSample>& samples_;
  FieldBasis basis_;
  LayInformation board_;
  Eigen::MatrixXd kernel_;
  JointPriors priors_;
  Eigen::VectorXd nominal_, sigma_;
  std::vector<PoseNoise> noise_;
  Eigen::MatrixXd F_, H0_, H_;
  Eigen::MatrixXd L_;
  Eigen::VectorXd x_, right_, half_, solution_;
  double squares_{0.0};
};

}  // namespace

std::optional<JointFit> fit_jointly(const ArmModel& model, const JointPriors& priors,
                                    const std::vector<PoseSample>& samples, double field_radius,
                                    const LaidDots& board) {
  Equations equations(model, priors, samples, basis_over_disc(field_radius, priors.field_width),
                      board);
  if (!equations.solve()) return std::nullopt;
  return equations.result();
}

std::optional<double> joint_log_likelihood(const ArmModel& model, const JointPriors& priors,
                                           const std::vector<PoseSample>& samples,
                                           double field_radius, const LaidDots& board) {
  Equations equations(model, priors, samples, basis_over_disc(field_radius, priors.field_width),
                      board);
  if (!equations.solve()) return std::nullopt;
  return equations.log_likelihood();
}

}  // namespace planar
