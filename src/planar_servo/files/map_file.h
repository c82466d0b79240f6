#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "planar_servo/learn/field/fit_lamp_field.h"
#include "planar_servo/loop/vision/see_tool.h"

namespace planar {

/// The method of a map.yaml that holds a field at the lamps.
constexpr char kLampFieldMethod[] = "lamp_field";

/// Returns the text of map.yaml: the field, from which it can be evaluated bit for bit (lengths in
/// metres as they are held), the tool found with it, and the figures of its fit.
std::string lamp_field_text(const LampFieldFit& fit, const std::vector<Origin>& origins,
                            const std::string& program);

/// Returns the text of map.yaml: the map, from which it can be evaluated bit for bit (lengths in
/// metres as they are held, in keys that end with `_m`), the figures of its fit, and its origins.
std::string map_text(const MapResult& result, const std::vector<Origin>& origins,
                     const std::string& program);
/// Returns the same of a map that was made from pairs alone.
std::string map_text(const MapResult& result, const std::filesystem::path& pairs,
                     const std::string& program);

/// A map, and how good its fit found it.
struct MapRecord {
  VisionErrorMap map;
  MapQuality quality;
  /// What the fit left at left-out places, rms, metres; NaN where the file does not say it.
  double loo_rms{std::numeric_limits<double>::quiet_NaN()};
};

/// Returns why a map's fit rejects it, which the log shows; empty where it does not. Throws
/// InputError with this remedy unless the map is accepted all the same.
std::optional<std::string> accept_objection(const std::optional<Refusal>& objection,
                                            const std::string& remedy,
                                            const std::filesystem::path& map, bool accepted);

/// Reads map.yaml of either kind. Throws InputError naming every fault of the file, and when its
/// kernel matrix cannot be solved.
MapRecord read_map(const std::filesystem::path& path);

}  // namespace planar
