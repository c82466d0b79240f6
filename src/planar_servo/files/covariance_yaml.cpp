#include "planar_servo/files/covariance_yaml.h"

namespace planar {

void add_covariance(YamlWriter& writer, const std::vector<std::string>& variables,
                    const Eigen::MatrixXd& covariance) {
  std::vector<std::vector<double>> rows;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    rows.emplace_back();
    for (Eigen::Index j = 0; j < covariance.cols(); ++j) rows.back().push_back(covariance(i, j));
  }
  writer.add("covariance_of", variables).add("covariance", rows);
}

Eigen::MatrixXd read_covariance(const YamlNode& root, std::size_t size) {
  root.allow("covariance_of");
  const auto n = static_cast<Eigen::Index>(size);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  const std::vector<YamlNode> rows = root.list("covariance", size);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto values = rows[i].as_numbers(size);
    if (!values) return Eigen::MatrixXd::Zero(n, n);
    covariance.row(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::RowVectorXd>(values->data(), n);
  }
  if (!covariance.isApprox(covariance.transpose()) || (covariance.diagonal().array() < 0.0).any()) {
    root.add_fault("covariance must be symmetric, with variances of 0 or more on its diagonal");
  }
  return covariance;
}

}  // namespace planar
