#include "planar_servo/files/health_file.h"

#include "planar_servo/core/units.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {
namespace {

void list_fields(Fields& fields, HealthPlace& place) {
  fields.text("id", place.id);
  fields.numbers("theta_deg", place.theta, kDegree);
  fields.numbers("lamp1_mm", place.lamps_B[0], kMillimetre);
  fields.numbers("lamp2_mm", place.lamps_B[1], kMillimetre);
  fields.number("sigma_mm", place.sigma_m, kMillimetre, Range::positive());
}

void list_fields(Fields& fields, const std::string& key, double& least, double& most) {
  fields.row(key, [&](RowFields& row) {
    row.number(least, 1.0, Range::at_least(0.0));
    row.number(most, 1.0, Range::at_least(0.0));
  });
}

void list_fields(Fields& fields, LookRange& range) {
  auto& [least, most] = range;
  list_fields(fields, "level", least.level, most.level);
  list_fields(fields, "background", least.background, most.background);
  list_fields(fields, "blur_px", least.blur_px, most.blur_px);
  list_fields(fields, "axis_ratio", least.axis_ratio, most.axis_ratio);
}

void list_fields(Fields& fields, HealthRecord& record) {
  fields.number("separation_mm", record.separation_m, kMillimetre, Range::positive());
  fields.number("separation_spread_mm", record.separation_spread_m, kMillimetre,
                Range::at_least(0.0));
  fields.number("distance_from_command_mm", record.distance_m, kMillimetre, Range::at_least(0.0));
  fields.number("turn_from_command_deg", record.turn, kDegree, Range::at_least(0.0));
  fields.maps("places", record.places, [&](HealthPlace& place) { list_fields(fields, place); });
  if (!fields.given("looks", record.looks.has_value())) return;
  if (fields.reading()) record.looks.emplace();
  fields.maps("looks", *record.looks, [&](LookRange& range) { list_fields(fields, range); });
}

}  // namespace

std::string health_text(const HealthRecord& record, const std::string& program,
                        const std::vector<Origin>& origins) {
  YamlWriter yaml("health", program);
  yaml.add_inputs(input_records(origins));
  HealthRecord written = record;
  list_fields(yaml, written);
  return yaml.text();
}

HealthRecord read_health(const std::filesystem::path& path) {
  YamlReader reader(path, "health");
  HealthRecord record;
  list_fields(reader, record);
  reader.throw_if_faulty();
  return record;
}

}  // namespace planar
