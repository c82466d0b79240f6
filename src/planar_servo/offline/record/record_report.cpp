#include "planar_servo/offline/record/record_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

namespace planar {

std::string record_text(const RecordReport& report, const FrameCounts& frames,
                        const std::filesystem::path& folder) {
  std::string text = fmt::format(
      "{} positions recorded ({} were there before): {} frames, {} of them full, in {}\n"
      "camera: {}\n",
      report.recorded, report.present, report.frames, report.full_frames, folder.string(),
      describe(frames));
  if (!report.skipped.empty())
    text += fmt::format("left out for want of a reading: {}; start again to record them\n",
                        fmt::join(report.skipped, ", "));
  return text;
}

nlohmann::json record_json(const RecordReport& report, const FrameCounts& frames) {
  return {{"recorded", report.recorded},
          {"present", report.present},
          {"frames", report.frames},
          {"full_frames", report.full_frames},
          {"frames_incomplete", frames.incomplete},
          {"frames_frozen", frames.frozen},
          {"camera_reopened", frames.reopened},
          {"without_lamps", report.without_lamps},
          {"skipped", report.skipped}};
}

}  // namespace planar
