#include "planar_servo/files/map_file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <variant>
#include <vector>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {
namespace {

/// The method of a radial basis function map's file, in the order of KernelShape.
constexpr std::array<const char*, 2> kRbfMethods{"gaussian_rbf", "multiquadric_rbf"};

constexpr char kSparseMethod[] = "sparse_gaussian_rbf";

/// (cos phi, sin phi) of the tool at each centre: the tail then ends with these two terms.
constexpr char kDirections[] = "tool_directions";

std::vector<double> numbers_of(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}

std::vector<std::vector<double>> rows_of(const Eigen::Matrix2Xd& columns) {
  std::vector<std::vector<double>> rows;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) rows.push_back(numbers_of(columns.col(i)));
  return rows;
}

Eigen::Vector2d read_point(const YamlNode& node, const std::string& key) {
  const std::vector<double> xy = node.numbers(key, 2);
  return {xy[0], xy[1]};
}

Eigen::Matrix2Xd read_points(const YamlNode& node, const std::string& key) {
  const std::vector<YamlNode> rows = node.list(key);
  Eigen::Matrix2Xd points(2, rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double> xy = rows[i].as_numbers(2).value_or(std::vector<double>{0.0, 0.0});
    points.col(static_cast<Eigen::Index>(i)) << xy[0], xy[1];
  }
  return points;
}

Eigen::Matrix2Xd read_points(const YamlNode& node, const std::string& key, Eigen::Index size) {
  Eigen::Matrix2Xd points = read_points(node, key);
  if (points.cols() != size) {
    node.child(key).add_fault(
        fmt::format("{} has {} points; {} are needed", key, points.cols(), size));
  }
  return points;
}

Eigen::Matrix2Xd read_centers(const YamlNode& node) {
  Eigen::Matrix2Xd centers = read_points(node, "centers_m");
  if (centers.cols() == 0) node.child("centers_m").add_fault("centers_m has no points");
  return centers;
}

Eigen::VectorXd read_counts(const YamlNode& node, Eigen::Index size) {
  const std::vector<double> counts =
      node.numbers("pairs_per_center", static_cast<std::size_t>(size));
  for (const double count : counts) {
    if (count >= 1.0) continue;
    node.child("pairs_per_center").add_fault("pairs_per_center has a number below 1");
    break;
  }
  return Eigen::Map<const Eigen::VectorXd>(counts.data(), static_cast<Eigen::Index>(counts.size()));
}

void add_region(YamlWriter& yaml, const ValidRegion& region) {
  std::vector<std::vector<double>> hull;
  for (const Eigen::Vector2d& corner : region.hull) hull.push_back(numbers_of(corner));
  yaml.add("hull_m", hull);
  yaml.add("hull_margin_m", region.margin);
}

ValidRegion read_region(const YamlNode& node) {
  ValidRegion region;
  const Eigen::Matrix2Xd hull = read_points(node, "hull_m");
  for (Eigen::Index i = 0; i < hull.cols(); ++i) region.hull.emplace_back(hull.col(i));
  region.margin = node.number_in("hull_margin_m", 0.0);
  return region;
}

void add_tail(YamlWriter& yaml, const TailBasis& basis, const Eigen::Matrix2Xd& tail) {
  yaml.add("tail_degree", basis.degree);
  yaml.add("tail_origin_m", numbers_of(basis.origin));
  yaml.add("tail_scale_m", basis.scale);
  yaml.add("tail_m", rows_of(tail));
}

void add_map(YamlWriter& yaml, const IdwMap& map) {
  yaml.add("method", "idw");
  add_region(yaml, map.region);
  yaml.add("centers_m", rows_of(map.centers));
  yaml.add("errors_m", rows_of(map.errors));
}

/// What dense and sparse maps have in common, but for their widths and weights.
template <typename Parameters>
void add_shared(YamlWriter& yaml, const Parameters& parameters) {
  yaml.add("ridge", parameters.ridge);
  yaml.add("signal_sigma_m", parameters.signal_sigma);
  yaml.add("sigma_limit_m", parameters.sigma_limit);
  add_tail(yaml, parameters.tail_basis, parameters.tail);
  add_region(yaml, parameters.region);
  yaml.add("centers_m", rows_of(parameters.centers));
}

void add_map(YamlWriter& yaml, const RbfMap& map) {
  const RbfParameters& parameters = map.parameters();
  yaml.add("method", kRbfMethods[static_cast<std::size_t>(parameters.kernel.shape)]);
  yaml.add("width_m", parameters.kernel.width);
  yaml.add("span_m", parameters.kernel.span);
  add_shared(yaml, parameters);
  yaml.add("pairs_per_center",
           std::vector<double>(parameters.counts.begin(), parameters.counts.end()));
  yaml.add("weights_m", rows_of(parameters.weights));
  if (parameters.tail_basis.with_direction) yaml.add(kDirections, rows_of(parameters.directions));
}

/// Its lower triangle, row after row.
std::vector<double> packed(const Eigen::MatrixXd& lower) {
  std::vector<double> numbers;
  for (Eigen::Index i = 0; i < lower.rows(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) numbers.push_back(lower(i, j));
  return numbers;
}

Eigen::MatrixXd read_packed(const YamlNode& node, const std::string& key, Eigen::Index size) {
  const std::vector<double> numbers =
      node.numbers(key, static_cast<std::size_t>(size * (size + 1) / 2));
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(size, size);
  auto number = numbers.begin();
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j <= i && number != numbers.end(); ++j) lower(i, j) = *number++;
  return lower;
}

void add_map(YamlWriter& yaml, const SparseRbfMap& map) {
  const SparseRbfParameters& parameters = map.parameters();
  yaml.add("method", kSparseMethod);
  yaml.add("width_m", parameters.width);
  add_shared(yaml, parameters);
  yaml.add("weights_m", rows_of(parameters.weights));
  yaml.add("factor", packed(parameters.factor));
}

IdwMap read_idw(const YamlNode& node) {
  IdwMap map;
  map.region = read_region(node);
  map.centers = read_centers(node);
  map.errors = read_points(node, "errors_m", map.centers.cols());
  return map;
}

void read_tail_basis(const YamlNode& node, TailBasis& basis) {
  basis.degree = node.whole_number_in("tail_degree", -1, 3);
  basis.origin = read_point(node, "tail_origin_m");
  basis.scale = node.positive("tail_scale_m");
}

KernelShape shape_of(const std::string& method) {
  return method == kRbfMethods[0] ? KernelShape::kGaussian : KernelShape::kMultiquadric;
}

template <typename Parameters>
void read_shared(const YamlNode& node, Parameters& parameters) {
  parameters.ridge = node.number_in("ridge", 0.0);
  parameters.signal_sigma = node.number_in("signal_sigma_m", 0.0);
  parameters.sigma_limit = node.number_in("sigma_limit_m", 0.0);
  read_tail_basis(node, parameters.tail_basis);
  parameters.tail = read_points(node, "tail_m", parameters.tail_basis.terms());
  parameters.region = read_region(node);
  parameters.centers = read_centers(node);
  parameters.weights = read_points(node, "weights_m", parameters.centers.cols());
}

RbfParameters read_rbf(const YamlNode& node, KernelShape shape) {
  RbfParameters parameters;
  parameters.kernel.shape = shape;
  parameters.kernel.width = node.positive("width_m");
  parameters.kernel.span = node.number_in("span_m", 0.0);
  parameters.tail_basis.with_direction = node.has(kDirections);
  read_shared(node, parameters);
  if (parameters.tail_basis.with_direction)
    parameters.directions = read_points(node, kDirections, parameters.centers.cols());
  parameters.counts = read_counts(node, parameters.centers.cols());
  return parameters;
}

SparseRbfParameters read_sparse_rbf(const YamlNode& node) {
  SparseRbfParameters parameters;
  parameters.width = node.positive("width_m");
  read_shared(node, parameters);
  parameters.factor =
      read_packed(node, "factor", parameters.centers.cols() + parameters.tail_basis.terms());
  if (!(parameters.factor.diagonal().array() > 0.0).all())
    node.child("factor").add_fault("factor has a diagonal element that is not positive");
  return parameters;
}

/// Each term with its standard deviation.
void add_cell(YamlWriter& yaml, const CellDiagnosis& cell) {
  if (cell.terms.empty()) return;
  yaml.begin_map("cell");
  for (const CellTerm& term : cell.terms) {
    const CellFaultName& name = name_of(term.fault);
    yaml.add(name.key, std::vector<double>{term.value / name.unit, term.sigma / name.unit});
  }
  yaml.end_map();
}

void add_figures(YamlWriter& yaml, const MapResult& result) {
  yaml.begin_map("fit");
  yaml.add("n_used", static_cast<int>(result.n_used));
  yaml.add("raw_rms_mm", result.raw_rms / kMillimetre);
  yaml.add("loo_rms_mm", result.loo_rms / kMillimetre);
  if (std::isfinite(result.noise_sigma)) yaml.add("noise_mm", result.noise_sigma / kMillimetre);
  yaml.add("worth_using", result.worth_using);
  std::vector<std::string> rejected;
  for (const RejectedSample& sample : result.rejected) rejected.push_back(sample.id);
  yaml.add("rejected", rejected);
  add_cell(yaml, result.cell);
  yaml.end_map();
}

void allow_figures(const YamlNode& root) {
  const YamlNode fit = root.child("fit");
  for (const char* key :
       {"n_used", "raw_rms_mm", "loo_rms_mm", "noise_mm", "worth_using", "rejected", "cell"})
    fit.allow(key);
}

template <typename Value>
Value checked(const YamlDocument& document, Value value) {
  document.throw_if_faulty();
  return value;
}

}  // namespace

std::string map_text(const MapResult& result, const std::filesystem::path& pairs,
                     const std::string& program) {
  YamlWriter yaml = YamlWriter::with_header("map", program);
  yaml.add_inputs({pairs});
  add_figures(yaml, result);
  std::visit([&](const auto& map) { add_map(yaml, map); }, result.map);
  return yaml.text();
}

ErrorMap read_map(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read(path, "map");
  const YamlNode root = document.root();
  allow_figures(root);
  const std::string method =
      root.choice("method", {kRbfMethods[0], kRbfMethods[1], kSparseMethod, "idw"});
  const auto read = [&]() -> ErrorMap {
    if (method == "idw") return checked<IdwMap>(document, read_idw(root));
    if (method == kSparseMethod)
      return SparseRbfMap(checked<SparseRbfParameters>(document, read_sparse_rbf(root)));
    return RbfMap(checked<RbfParameters>(document, read_rbf(root, shape_of(method))));
  };
  try {
    return read();
  } catch (const WorkError& e) {
    throw InputError(path.string() + ": " + e.what());
  }
}

}  // namespace planar
