#include "planar_servo/files/health_file.h"

#include "planar_servo/core/units.h"
#include "planar_servo/io/yaml_fields.h"

namespace planar {
namespace {

void list_fields(Fields& fields, HealthPlace& place) {
  fields.text("id", place.id);
  fields.numbers("theta_deg", place.theta, kDegree);
  fields.numbers("lamp1_mm", place.lamps_B[0], kMillimetre);
  fields.numbers("lamp2_mm", place.lamps_B[1], kMillimetre);
  fields.number("sigma_mm", place.sigma_m, kMillimetre, Range::positive());
}

void list_fields(Fields& fields, HealthRecord& record) {
  fields.number("separation_mm", record.separation_m, kMillimetre, Range::positive());
  fields.number("separation_spread_mm", record.separation_spread_m, kMillimetre,
                Range::at_least(0.0));
  fields.number("distance_from_command_mm", record.distance_m, kMillimetre, Range::at_least(0.0));
  fields.number("turn_from_command_deg", record.turn, kDegree, Range::at_least(0.0));
  fields.maps("places", record.places, [&](HealthPlace& place) { list_fields(fields, place); });
}

}  // namespace

std::string health_text(const HealthRecord& record, const std::string& program,
                        const std::vector<Origin>& origins) {
  YamlWriter yaml = YamlWriter::with_header("health", program);
  yaml.add_inputs(input_records(origins));
  FieldWriter writer(yaml);
  HealthRecord written = record;
  list_fields(writer, written);
  return yaml.text();
}

HealthRecord read_health(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read(path, "health");
  FieldReader reader(document.root());
  HealthRecord record;
  list_fields(reader, record);
  document.throw_if_faulty();
  return record;
}

}  // namespace planar
