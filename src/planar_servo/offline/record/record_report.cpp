#include "planar_servo/offline/record/record_report.h"

#include <fmt/format.h>

namespace planar {

ReportList record_list(const RecordReport& report, const FrameCounts& frames,
                       const std::filesystem::path& folder) {
  ReportList list;
  list.line("",
            "{recorded} positions recorded ({present} were there before): {frames} frames, "
            "{full_frames} of them full",
            report.recorded, report.present, report.frames, report.full_frames);
  list.line("", fmt::format("recording: {}", folder.string()));
  list.line("", "camera: " + describe(frames));
  list.unprinted("frames_incomplete", frames.incomplete);
  list.unprinted("frames_frozen", frames.frozen);
  list.unprinted("camera_reopened", frames.reopened);
  list.unprinted("without_lamps", report.without_lamps);
  list.line_if(!report.skipped.empty(), "",
               "left out for want of a reading: {skipped}; start again to record them",
               report.skipped);
  return list;
}

}  // namespace planar
