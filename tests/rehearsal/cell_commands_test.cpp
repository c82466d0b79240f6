#include "planar_servo/machine/rehearsal/live_cell.h"

#include <array>
#include <catch2/catch.hpp>
#include <opencv2/core.hpp>

#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

/// The mean grey level of the sensor; the board is brighter than what it hides.
double mean_level(LiveCell& live, const cv::Size& sensor_px) {
  return cv::mean(live.expose({{}, sensor_px}, 1.0))[0];
}

/// Of a cell without marks, whose camera notes whether it is on.
CellHands hands(bool* camera_is_on = nullptr) {
  return {[] { return false; },
          [camera_is_on](bool on) {
            if (camera_is_on != nullptr) *camera_is_on = on;
          }};
}

TEST_CASE("The board comes into view and leaves it by commands") {
  const VirtualHardware hardware = test::sample_hardware();
  LiveCell live(draw_truth(3), hardware);
  const double without = mean_level(live, hardware.sensor_px);
  CHECK(obey_command("board hold 3", live, hands()) == "the board is held, view 3");
  const double held = mean_level(live, hardware.sensor_px);
  CHECK(held > 2.0 * without);
  CHECK(obey_command("  board  lay 0 ", live, hands()) == "the board is laid, view 0");
  const double laid = mean_level(live, hardware.sensor_px);
  CHECK(laid > 2.0 * without);
  CHECK(std::abs(laid - held) > 1.0);
  CHECK(obey_command("board remove", live, hands()) == "the board is removed");
  CHECK(std::abs(mean_level(live, hardware.sensor_px) - without) < 0.1);
}

TEST_CASE("The arm is put at its marks by a command, where that is possible") {
  LiveCell live(draw_truth(3), test::sample_hardware());
  CHECK(obey_command(" arm marks", live, {[] { return true; }, {}}) ==
        "the arm stands at its marks");
  CHECK(obey_command("arm marks", live, hands()).rfind("the arm is not put at", 0) == 0);
}

TEST_CASE("A work is laid elsewhere by a command") {
  Truth truth = draw_truth(3);
  LiveCell without(truth, test::sample_hardware());
  CHECK(obey_command("work 100 200 5", without, hands()).rfind("there is no work", 0) == 0);
  WorkpieceTruth bar;
  bar.plate_to_m = {0.05, 0.01};
  bar.p_BW = {0.3, 0.0, 0.0};
  truth.works.push_back(bar);
  const VirtualHardware hardware = test::sample_hardware();
  LiveCell live(truth, hardware);
  const cv::Mat before = live.expose({{}, hardware.sensor_px}, 1.0);
  CHECK(obey_command("work -100 250.5 30", live, hands()) ==
        "the work lies at (-100.000, 250.500) mm, turned by 30 deg");
  const cv::Mat after = live.expose({{}, hardware.sensor_px}, 1.0);
  CHECK(cv::norm(before, after, cv::NORM_INF) > 30.0);
}

TEST_CASE("The camera's power is switched by commands") {
  LiveCell live(draw_truth(3), test::sample_hardware());
  bool is_on = true;
  CHECK(obey_command("camera off", live, hands(&is_on)) == "the camera is off");
  CHECK_FALSE(is_on);
  CHECK(obey_command("camera on", live, hands(&is_on)) == "the camera is on");
  CHECK(is_on);
}

TEST_CASE("A command that is not understood is answered with what is allowed") {
  LiveCell live(draw_truth(3), test::sample_hardware());
  for (const char* line :
       {"", "board", "board hold", "board hold x", "board hold -1", "board lay 1.5", "camera",
        "camera away", "board hold 1 2", "work", "work 1 2", "work 1 2 x", "work 1 2 nan", "arm",
        "arm home", "board drop 1", "board remove 1", "bord hold 1", "board hold 99999999999"}) {
    INFO(line);
    const std::string answer = obey_command(line, live, hands());
    CHECK(answer.rfind("not understood: '" + std::string(line) + "'", 0) == 0);
    CHECK(answer.find(kCellCommands) != std::string::npos);
  }
}

}  // namespace
}  // namespace planar
