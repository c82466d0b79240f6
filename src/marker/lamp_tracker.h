#pragma once

#include <memory>

#include "core/frame.h"
#include "marker/lamp.h"

namespace planar {

/// Finds the two lamps in a frame (whole sensor or region): where a prediction is given, by
/// ViSP's vpDot2 in a window round it; without one, or when that fails, by detection in the whole
/// image. Then measures each centre by the method asked for, checks the distance and decides which
/// lamp is which. Keeps no state that changes a result: the same frame and expectation always give
/// the same pair (only large buffers are kept from frame to frame).
class LampTracker {
 public:
  explicit LampTracker(CenterMethod method);
  ~LampTracker();
  LampTracker(LampTracker&&) noexcept;
  LampTracker& operator=(LampTracker&&) noexcept;

  LampPair locate(const Frame& frame, const PairExpectation& expectation);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
