#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/files/camera/camera_file.h"

namespace planar {

/// Reads the first camera of a file in the form of ViSP's vpXmlParserCamera: with distortion when
/// the file has that model, else without. Throws InputError when there is neither.
CameraRecord read_camera_xml(const std::filesystem::path& path);

/// Returns the text of a file in the form of ViSP's vpXmlParserCamera. Throws InputError for a
/// model other than pinhole and visp.
std::string camera_xml(const CameraRecord& record, const std::string& camera_name);

}  // namespace planar
