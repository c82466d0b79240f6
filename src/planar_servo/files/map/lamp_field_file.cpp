#include "planar_servo/files/map/lamp_field_file.h"

#include "planar_servo/core/units.h"
#include "planar_servo/files/map/map_fields.h"

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
  fields.check(field.p_camera_B.z() > 0.0, "p_camera_B_m has a height that is not positive",
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
  yaml.add("raw_rms_mm", fit.held_out.raw_rms / kMillimetre);
  yaml.add("loo_rms_mm", fit.held_out.rms / kMillimetre);
  add_quality(yaml, fit.held_out.quality());
  yaml.add("left_out", fit.left_out);
  yaml.add("harmonics", fit.estimate.size.harmonics);
  yaml.map("fixed_by", [&] {
    yaml.add("scale", name_in(kFieldSources, fit.fixed_by.scale));
    yaml.add("datum", name_in(kFieldSources, fit.fixed_by.datum));
    yaml.add("turn", name_in(kFieldSources, fit.fixed_by.turn));
  });
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

LampField read_lamp_field(YamlReader& reader) {
  LampField field;
  list_fields(reader, field);
  reader.throw_if_faulty();
  return field;
}

}  // namespace planar
