#include <catch2/catch.hpp>
#include <cstdlib>
#include <new>

#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/lamps/lamp_detector.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "support/rendered_lamp.h"

// Not under AddressSanitizer, which has allocation functions of its own. GCC defines this by
// itself.
#ifdef __has_feature
#if __has_feature(address_sanitizer)
#define __SANITIZE_ADDRESS__
#endif
#endif
#ifndef __SANITIZE_ADDRESS__

// Counts what this test program allocates: operator new, and the pixels of cv::Mat, which come from
// malloc and not from here, through their addresses. Inlined, a delete looks to GCC like a free()
// of what new returned.
namespace {

std::size_t allocations = 0;

}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto step = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace planar {
namespace {

TEST_CASE("measure_lamp allocates nothing after the first lamp") {
  std::mt19937 random(19);
  cv::Mat scene = test::background({128, 128});
  test::add_lamp(scene, {{64.2, 63.9}});
  const cv::Mat image = test::expose(scene, random);
  const Blob blob = describe_blob(image, {43, 43, 43, 43}, 100);
  for (const CenterMethod method : {CenterMethod::kAuto, CenterMethod::kFast}) {
    measure_lamp(image, blob, method);
    const std::size_t before = allocations;
    const LampStatus status = measure_lamp(image, blob, method).status;
    const std::size_t during = allocations - before;
    CHECK(status == LampStatus::kOk);
    CHECK(during == 0);
  }
}

TEST_CASE("LampDetector and choose_pair allocate nothing after the first frame") {
  std::mt19937 random(18);
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 3; ++i) {
    cv::Mat scene = test::background({900, 700});
    test::add_lamp(scene, {{300.0 + 20.0 * i, 300.0}});
    test::add_lamp(scene, {{500.0 + 20.0 * i, 340.0}});
    test::add_lamp(scene, {{60.0, 60.0 + 30.0 * i}, 8.0});
    frames.push_back(test::expose(scene, random));
  }
  PairExpectation expectation;
  expectation.diameter_over_separation = {0.2, 0.2};
  LampDetector detector;
  for (const cv::Rect& window : {cv::Rect(0, 0, 900, 700), cv::Rect(200, 200, 400, 250)}) {
    std::size_t in_later_frames = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const std::size_t before = allocations;
      const std::vector<Blob>& found = detector.detect(frames[i], window);
      const PairChoice pair = choose_pair(found, expectation);
      if (i > 0) in_later_frames += allocations - before;
      CHECK(pair.status == LampStatus::kAmbiguous);
    }
    CHECK(in_later_frames == 0);
  }
  const std::size_t before = allocations;
  std::vector<Blob> more(1);
  CHECK(allocations > before);  // the count counts
}

}  // namespace
}  // namespace planar

#endif
