#include "lamps/detection_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "lamps/cluttered_frame.h"
#include "lamps/detection_methods.h"
#include "lamps/full_read.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/lamps/lamp_tracker.h"

namespace planar::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kDistanceShare = 0.03;  // the tolerance of a calibrated plane

const std::vector<FrameKind>& frame_kinds() {
  static const std::vector<FrameKind> kinds = {{"dark", 0, false, false},
                                               {"12 to 120 px, 40 to 400 levels", 0, false, true},
                                               {"400 specks, other lights", 400, true, false},
                                               {"20,000 specks, other lights", 20000, true, false}};
  return kinds;
}

struct Tally {
  int frames{0}, missed{0}, other{0}, false_pairs{0};
  std::vector<double> times;

  void add(const std::vector<Blob>& found, const ClutteredFrame& frame);
};

/// Counts the finds in a frame. A lamp is missed when no find lies within a quarter diameter of it.
/// Other finds are those that are neither a lamp nor the third light. A pair is false when the
/// distance and the sizes of the lamps pick another pair or leave several.
void Tally::add(const std::vector<Blob>& found, const ClutteredFrame& frame) {
  ++frames;
  const auto is_lamp = [&](const Blob& blob, const test::RenderedLamp& lamp) {
    return (blob.uv_px - lamp.center_px).norm() < 0.25 * lamp.diameter_px;
  };
  int seen = 0;
  for (const test::RenderedLamp& lamp : frame.lamps()) {
    if (std::any_of(found.begin(), found.end(), [&](const auto& p) { return is_lamp(p, lamp); }))
      ++seen;
  }
  missed += 2 - seen;
  if (frame.third_lamp() && std::any_of(found.begin(), found.end(), [&](const auto& p) {
        return is_lamp(p, *frame.third_lamp());
      })) {
    ++seen;
  }
  other += static_cast<int>(found.size()) - seen;
  PairExpectation expectation;
  expectation.separation_px = {(1.0 - kDistanceShare) * frame.separation_px(),
                               (1.0 + kDistanceShare) * frame.separation_px()};
  const double diameter_px = frame.lamps()[0].diameter_px / frame.separation_px();
  expectation.diameter_over_separation = {diameter_px, diameter_px};
  const PairChoice pair = choose_pair(found, expectation);
  if (pair.status != LampStatus::kAmbiguous) return;
  const auto is_any = [&](const Blob& blob) {
    return is_lamp(blob, frame.lamps()[0]) || is_lamp(blob, frame.lamps()[1]);
  };
  if (!pair.is_unique || !is_any(found[pair.index[0]]) || !is_any(found[pair.index[1]]))
    ++false_pairs;
}

nlohmann::json report(const FrameKind& kind, const std::vector<DetectionMethodUnderTest>& methods,
                      const std::vector<Tally>& tallies) {
  nlohmann::json json;
  fmt::print("{}\n", kind.name);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const Tally& tally = tallies[m];
    const double time = median(tally.times), unit = median(tallies[0].times);
    fmt::print("| {:24} | {:9.3f} ms | {:8.2f} |", methods[m].name, 1e3 * time, time / unit);
    json[methods[m].name] = {{"median_s", time}, {"time_over_full_read", time / unit}};
    if (m > 0) {
      fmt::print(" {:4} of {:5} missed, {:6} other, {:4} false pairs in {:5} frames |",
                 tally.missed, 2 * tally.frames, tally.other, tally.false_pairs, tally.frames);
      json[methods[m].name].update({{"frames", tally.frames},
                                    {"missed", tally.missed},
                                    {"other", tally.other},
                                    {"false_pairs", tally.false_pairs}});
    }
    fmt::print("\n");
  }
  return json;
}

}  // namespace

nlohmann::json measure_detection(int frames, unsigned seed) {
  const std::vector<DetectionMethodUnderTest> methods = detection_methods();
  ClutteredFrame frame(seed);
  nlohmann::json json;
  fmt::print("\ntwo lamps in frames of {} x {} pixels; medians, and over one full read\n",
             frame.image().cols, frame.image().rows);
  for (const FrameKind& kind : frame_kinds()) {
    std::vector<Tally> tallies(methods.size());
    for (int i = 0; i < frames; ++i) {
      frame.draw(kind);
      for (std::size_t m = 0; m < methods.size(); ++m) {
        if (i % methods[m].every != 0) continue;
        make_cold(frame.image());
        const auto begin = Clock::now();
        const std::vector<Blob> found =
            methods[m].detect(frame.image(), frame.lamps()[0].diameter_px);
        tallies[m].times.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
        tallies[m].add(found, frame);
      }
    }
    json[kind.name] = report(kind, methods, tallies);
  }
  return json;
}

}  // namespace planar::bench
