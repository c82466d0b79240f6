#include "planar_servo/tables/frame_table.h"

#include <catch2/catch.hpp>

#include "planar_servo/core/error.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;

TEST_CASE("A frame comes back as it was written") {
  const test::TemporaryFolder folder;
  const FrameRow frame{"t1",          "images/t1.pgm",     1.5, Plan::kTrain, {0.1, -0.2, 0.3},
                       {10, -20, 30}, {100, 200, 512, 512}};
  folder.write("frames.csv", frames_header() + frame_line(frame));
  const FrameRow back = read_frames(folder.path()).at(0);
  CHECK(back.image == frame.image);
  CHECK((back.theta - frame.theta).norm() < 1e-10);
  CHECK(back.pulses == frame.pulses);
  CHECK(back.region_px == frame.region_px);
}

TEST_CASE("A recording that is no folder, empty or of an unknown plan is refused") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_WITH(read_frames(folder / "absent"), Contains("is not a folder"));
  folder.write("frames.csv", frames_header());
  CHECK_THROWS_WITH(read_frames(folder.path()),
                    Contains("has no rows; record some with planar-record"));
  folder.write("frames.csv", frames_header() + "a,a.pgm,0,traning,0,0,0,0,0,0,0,0,8,8\n");
  CHECK_THROWS_WITH(read_frames(folder.path()), Contains("frames.csv:3: plan is 'traning'"));
}

}  // namespace
}  // namespace planar
