#include "planar_servo/offline/record/record_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace planar {

std::string record_text(const RecordReport& report, const FrameCounts& frames,
                        const std::filesystem::path& folder) {
  return fmt::format(
      "{} positions recorded ({} were there before): {} frames, {} of them full, in {}\n"
      "camera: {}\n",
      report.recorded, report.present, report.frames, report.full_frames, folder.string(),
      describe(frames));
}

nlohmann::json record_json(const RecordReport& report, const FrameCounts& frames) {
  return {{"recorded", report.recorded},
          {"present", report.present},
          {"frames", report.frames},
          {"full_frames", report.full_frames},
          {"frames_incomplete", frames.incomplete},
          {"frames_frozen", frames.frozen},
          {"camera_reopened", frames.reopened},
          {"without_lamps", report.without_lamps}};
}

}  // namespace planar
