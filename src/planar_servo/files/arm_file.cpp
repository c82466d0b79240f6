#include "planar_servo/files/arm_file.h"

#include "planar_servo/core/units.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/io/yaml_fields.h"

namespace planar {
namespace {

void list_harmonic(RowFields& row, ReducerHarmonic& harmonic) {
  for (Eigen::Vector3d* wave : {&harmonic.sine, &harmonic.cosine})
    for (double& amplitude : *wave) row.number(amplitude, kDegree);
}

void list_fields(Fields& fields, FoundArm& arm) {
  fields.numbers("link_lengths_mm", arm.link_lengths_m, kMillimetre, Range::positive());
  fields.numbers("zero_offsets_deg", arm.zero_offsets_rad, kDegree);
  // Sines of motors 1 to 3, then cosines; one row for each order.
  fields.rows("eccentricity_deg", arm.harmonics, list_harmonic);
}

void add_terms(YamlWriter& yaml, const std::vector<ArmTerm>& terms) {
  yaml.begin_list("terms");
  for (const ArmTerm& term : terms) {
    yaml.begin_item();
    yaml.add("name", term.key);
    yaml.add("value", term.value / term.unit);
    yaml.add("sigma", term.sigma / term.unit);
    yaml.add("determined", term.determined);
    yaml.end_map();
  }
  yaml.end_list();
}

}  // namespace

std::string found_arm_text(const FoundArm& arm, const std::vector<ArmTerm>& terms,
                           const std::vector<Origin>& origins, const std::string& program) {
  YamlWriter yaml = YamlWriter::with_header("arm", program);
  yaml.add_inputs(input_records(origins));
  FieldWriter writer(yaml);
  FoundArm written = arm;
  writer.map("arm", [&] { list_fields(writer, written); });
  add_terms(yaml, terms);
  return yaml.text();
}

FoundArm read_found_arm(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read(path, "arm");
  const YamlNode root = document.root();
  root.child("terms").allow_all();
  FieldReader reader(root);
  FoundArm arm;
  reader.map("arm", [&] { list_fields(reader, arm); });
  document.throw_if_faulty();
  return arm;
}

JointPlanner servo_planner(const CellSettings& cell) {
  JointPlanner planner = joint_planner(cell);
  if (cell.arm_found)
    planner.plan_for(
        read_found_arm(require_made(*cell.arm_found, "planar-fit-error-map --arm-out")));
  return planner;
}

}  // namespace planar
