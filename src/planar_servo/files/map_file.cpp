#include "planar_servo/files/map_file.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <variant>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/files/matrix_fields.h"

namespace planar {
namespace {

void list_tool(Fields& fields, ToolOffsets& tool) {
  fields.numbers("p_TP_m", tool.p_TP);
  fields.numbers("p_TS_m", tool.p_TS);
}

void list_wave(Fields& fields, LampField& field) {
  FieldBasis& wave = field.height_form.wave;
  if (!fields.given("wave", wave.centers.cols() > 0)) return;
  Eigen::VectorXd weights = field.height.tail(wave.centers.cols());
  fields.map("wave", [&] {
    fields.number("width_m", wave.width, 1.0, Range::positive());
    const auto size = list_centers(fields, wave.centers);
    if (fields.reading()) weights.resize(size.value_or(0));
    fields.numbers("weights_m", weights);
  });
  field.height.conservativeResize(3 + weights.size());
  field.height.tail(weights.size()) = weights;
}

void list_height(Fields& fields, LampField& field) {
  Eigen::Vector3d terms = field.height.head<3>();
  fields.numbers("terms_m", terms);
  field.height.head<3>() = terms;
  list_wave(fields, field);
  fields.number("reach_m", field.height_form.reach, 1.0, Range::positive());
  fields.numbers("p_camera_B_m", field.p_camera_B);
  fields.check(field.p_camera_B.z() > 0.0, {"p_camera_B_m has a height that is not positive"},
               "p_camera_B_m");
}

void list_fields(Fields& fields, LampField& field) {
  fields.number("width_m", field.basis.width, 1.0, Range::positive());
  fields.number("radius_m", field.basis.radius, 1.0, Range::positive());
  list_region(fields, field.region);
  const auto size = list_centers(fields, field.basis.centers);
  Eigen::Matrix2Xd weights = field.weights.transpose();
  list_points(fields, "weights_m", weights,
              size ? std::optional(field.basis.terms()) : std::nullopt);
  field.weights = weights.transpose();
  fields.map("lamps_height", [&] { list_height(fields, field); });
  fields.map("tool", [&] { list_tool(fields, field.tool); });
  list_columns(fields, "factor", field.factor, field.unknowns());
}

void add_figures(YamlWriter& yaml, const LampFieldFit& fit) {
  yaml.add("n_readings", static_cast<int>(fit.n_readings));
  yaml.add("n_unattended", static_cast<int>(fit.n_unattended));
  yaml.add("raw_rms_mm", mm(fit.held_out.raw_rms));
  yaml.add("loo_rms_mm", mm(fit.held_out.rms));
  add_quality(yaml, fit.quality());
  yaml.add("left_out", fit.left_out);
  yaml.add("harmonics", fit.estimate.size.harmonics);
  yaml.map("fixed_by", [&] {
    yaml.add("scale", name_in(kFieldSources, fit.fixed_by.scale));
    yaml.add("datum", name_in(kFieldSources, fit.fixed_by.datum));
    yaml.add("turn", name_in(kFieldSources, fit.fixed_by.turn));
  });
}

/// The key of (cos phi, sin phi) of the tool at each centre. The tail of a map that has this key
/// ends with these two terms.
constexpr char kToolDirections[] = "tool_directions";

void list_counts(Fields& fields, Eigen::VectorXd& counts, std::optional<Eigen::Index> size) {
  std::vector<double> values(counts.begin(), counts.end());
  const auto n = static_cast<std::size_t>(size.value_or(0));
  if (fields.numbers("pairs_per_center", values, n, 1.0, Range::at_least(1.0)))
    counts = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<int>(values.size()));
}

void list_tail(Fields& fields, TailBasis& basis, Eigen::Matrix2Xd& tail) {
  const bool known = fields.whole_number("tail_degree", basis.degree, -1, 3);
  fields.numbers("tail_origin_m", basis.origin);
  fields.number("tail_scale_m", basis.scale, 1.0, Range::positive());
  list_points(fields, "tail_m", tail, known ? std::optional(basis.terms()) : std::nullopt);
}

/// Visits what dense and sparse maps have in common before their weights. Returns the number of
/// centres. Empty when they could not be read.
template <typename Parameters>
std::optional<Eigen::Index> list_shared(Fields& fields, Parameters& parameters) {
  fields.number("ridge", parameters.ridge, 1.0, Range::at_least(0.0));
  fields.number("signal_sigma_m", parameters.signal_sigma, 1.0, Range::at_least(0.0));
  fields.number("sigma_limit_m", parameters.sigma_limit, 1.0, Range::at_least(0.0));
  list_tail(fields, parameters.tail_basis, parameters.tail);
  list_region(fields, parameters.region);
  return list_centers(fields, parameters.centers);
}

void list_fields(Fields& fields, IdwMap& map) {
  list_region(fields, map.region);
  const auto size = list_centers(fields, map.centers);
  list_points(fields, "errors_m", map.errors, size);
}

void list_fields(Fields& fields, RbfParameters& parameters) {
  bool& with_direction = parameters.tail_basis.with_direction;
  with_direction = fields.given(kToolDirections, with_direction);
  fields.number("width_m", parameters.kernel.width, 1.0, Range::positive());
  fields.number("span_m", parameters.kernel.span, 1.0, Range::at_least(0.0));
  const auto size = list_shared(fields, parameters);
  if (size)  // its equations are a matrix of so many rows and columns
    fields.check(*size <= kMostDense,
                 {fmt::format("centers_m has {} points", *size),
                  fmt::format("a map of this method has at most {}", kMostDense)},
                 "centers_m");
  list_counts(fields, parameters.counts, size);
  list_points(fields, "weights_m", parameters.weights, size);
  if (with_direction) list_points(fields, kToolDirections, parameters.directions, size);
}

void list_fields(Fields& fields, SparseRbfParameters& parameters) {
  fields.number("width_m", parameters.width, 1.0, Range::positive());
  const auto size = list_shared(fields, parameters);
  list_points(fields, "weights_m", parameters.weights, size);
  const Eigen::Index terms = size.value_or(0) + parameters.tail_basis.terms();
  if (list_lower_triangle(fields, "factor", parameters.factor, terms))
    fields.check((parameters.factor.diagonal().array() > 0.0).all(),
                 {"factor has a diagonal element that is not positive"}, "factor");
}

/// Adds each term of the cell with its standard deviation.
void add_cell(YamlWriter& yaml, const CellDiagnosis& cell) {
  if (cell.terms.empty()) return;
  yaml.map("cell", [&] {
    for (const CellTerm& term : cell.terms) {
      const CellFaultName& name = name_of(term.fault);
      yaml.add(name.key, std::vector<double>{term.value / name.unit, term.sigma / name.unit});
    }
  });
}

void add_figures(YamlWriter& yaml, const MapResult& result) {
  yaml.add("n_used", static_cast<int>(result.n_used));
  yaml.add("raw_rms_mm", mm(result.raw_rms));
  yaml.add("loo_rms_mm", mm(result.loo_rms));
  if (std::isfinite(result.noise_sigma)) yaml.add("noise_mm", mm(result.noise_sigma));
  if (std::isfinite(result.place_share)) {
    yaml.add("n_places", static_cast<int>(result.n_places));
    yaml.add("place_noise_mm", mm(result.place_sigma()));
    yaml.add("reading_noise_mm", mm(result.reading_sigma()));
  }
  add_quality(yaml, result.quality());
  std::vector<std::string> rejected;
  for (const RejectedSample& sample : result.rejected) rejected.push_back(sample.id);
  yaml.add("rejected", rejected);
  add_cell(yaml, result.cell);
}

/// Returns what a map is made of: its parameters, or the map itself.
IdwMap made_of(const IdwMap& map) {
  return map;
}
RbfParameters made_of(const RbfMap& map) {
  return map.parameters();
}
SparseRbfParameters made_of(const SparseRbfMap& map) {
  return map.parameters();
}

template <typename Parameters>
Parameters read_parameters(YamlReader& reader, Parameters parameters = {}) {
  list_fields(reader, parameters);
  reader.throw_if_faulty();
  return parameters;
}

ErrorMap read_map(YamlReader& reader, MapKind kind) {
  if (kind == MapKind::kIdw) return read_parameters<IdwMap>(reader);
  if (kind == MapKind::kSparseGaussianRbf)
    return SparseRbfMap(read_parameters<SparseRbfParameters>(reader));
  RbfParameters of_kind;
  of_kind.kernel.shape =
      kind == MapKind::kGaussianRbf ? KernelShape::kGaussian : KernelShape::kMultiquadric;
  return RbfMap(read_parameters(reader, of_kind));
}

}  // namespace

std::string lamp_field_text(const LampFieldFit& fit, const std::vector<Origin>& origins,
                            const std::string& program) {
  YamlWriter yaml("map", program);
  yaml.add_inputs(input_records(origins));
  yaml.map("fit", [&] { add_figures(yaml, fit); });
  yaml.add("method", kLampFieldMethod);
  LampField written = fit.field;
  list_fields(yaml, written);
  return yaml.text();
}

std::string map_text(const MapResult& result, const std::filesystem::path& pairs,
                     const std::string& program) {
  return map_text(result, with_origins_of({origin_of({Role::kPairs, pairs})}, pairs), program);
}

std::string map_text(const MapResult& result, const std::vector<Origin>& origins,
                     const std::string& program) {
  YamlWriter yaml("map", program);
  yaml.add_inputs(input_records(origins));
  yaml.map("fit", [&] { add_figures(yaml, result); });
  yaml.add("method", name(kind_of(result.map)));
  std::visit(
      [&](const auto& map) {
        auto parameters = made_of(map);
        list_fields(yaml, parameters);
      },
      result.map);
  return yaml.text();
}

std::optional<std::string> accept_objection(const std::optional<Refusal>& objection,
                                            const std::string& remedy,
                                            const std::filesystem::path& map, bool accepted) {
  if (!objection) return std::nullopt;
  const Refusal refusal{objection->fault, remedy, map, objection->cause};
  if (!accepted) throw InputError(refusal);
  spdlog::warn("accepted: " + refusal.text());
  return refusal.fault;
}

MapRecord read_map(const std::filesystem::path& path) {
  YamlReader reader(path, "map");
  MapQuality quality;
  double loo_rms = std::numeric_limits<double>::quiet_NaN();
  if (reader.given("fit"))
    reader.map("fit", [&] {
      quality = read_quality(reader);
      if (reader.given("loo_rms_mm")) reader.number("loo_rms_mm", loo_rms, kMillimetre);
    });
  std::vector<std::string> methods = names_of(kMapKinds);
  methods.emplace_back(kLampFieldMethod);
  std::string method;
  if (!reader.choice("method", method, methods)) {
    reader.allow_rest();
    reader.throw_if_faulty();
  }
  try {
    if (method == kLampFieldMethod) return {read_parameters<LampField>(reader), quality, loo_rms};
    return {read_map(reader, value_named(kMapKinds, method).value()), quality, loo_rms};
  } catch (const WorkError& e) {
    throw InputError(e.refusal().at(path));
  }
}

}  // namespace planar
