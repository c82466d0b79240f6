#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/field/fit_lamp_field.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {

/// The method of a map.yaml that holds a field at the lamps.
constexpr char kLampFieldMethod[] = "lamp_field";

/// Returns the text of map.yaml: the field, from which it can be evaluated bit for bit (lengths in
/// metres as they are held), the tool found with it, and the figures of its fit.
std::string lamp_field_text(const LampFieldFit& fit, const std::vector<Origin>& origins,
                            const std::string& program);

/// Reads the field from a map file of this method. Throws InputError naming every fault.
LampField read_lamp_field(YamlReader& reader);

}  // namespace planar
