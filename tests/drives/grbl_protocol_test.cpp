#include "planar_servo/hardware/drives/grbl_protocol.h"

#include <catch2/catch.hpp>
#include <random>

#include "support/grbl_bench.h"

namespace planar::grbl {
namespace {

using Catch::Contains;

template <typename Kind>
Kind line_of(const std::string& text) {
  const Line line = parse_line(text);
  INFO(text);
  REQUIRE(std::holds_alternative<Kind>(line));
  return std::get<Kind>(line);
}

Settings suitable() {
  Settings settings = test::stored_settings();
  for (const int scale : {100, 101, 102}) settings[scale] = 250.0;
  settings[10] = 1.0;
  return settings;
}

std::string refusal_of(const Settings& settings, HomeReference home = HomeReference::kTaught) {
  const auto refusal = unfitness(settings, test::grbl_settings_of("port", home));
  return refusal ? refusal->text() : "";
}

TEST_CASE("A report tells state, position and pressed inputs, whatever else it has") {
  const auto report =
      line_of<Report>("<Idle|MPos:1.000,-0.500,0.204|FS:480,0|Pn:PXZ|WCO:0.000,0.000,0.000>");
  CHECK(report.state == State::kIdle);
  REQUIRE(report.position_mm.has_value());
  CHECK((*report.position_mm)[1] == -0.5);
  CHECK((*report.position_mm)[2] == 0.204);
  CHECK(report.pressed('X'));
  CHECK(report.speed_mm_min == 480.0);
  CHECK_FALSE(report.pressed('Y'));
  CHECK(line_of<Report>("<Hold:1|MPos:0.000,0.000,0.000,7.000|Bf:99,1023>").state == State::kHold);
  CHECK_FALSE(line_of<Report>("<Jog|WPos:0.000,0.000,0.000|FS:88,0>").position_mm.has_value());
}

TEST_CASE("A board that still brakes to a hold turns, one on hold does not") {
  const auto turns = [](const std::string& state) {
    return line_of<Report>("<" + state + "|MPos:0.000,0.000,0.000>").turns;
  };
  for (const char* state : {"Jog", "Run", "Home", "Hold:1", "Door:2", "Door:3"})
    CHECK(turns(state));
  for (const char* state : {"Idle", "Alarm", "Hold:0", "Hold", "Door:0", "Sleep"})
    CHECK_FALSE(turns(state));
}

TEST_CASE("Answers, alarms, settings and banners of both firmwares are understood") {
  line_of<Accepted>("ok");
  CHECK(line_of<Rejected>("error:15").error == 15);
  CHECK(line_of<Alarm>("ALARM:3").number == 3);
  CHECK(line_of<StoredSetting>("$120=10.000").number == 120);
  CHECK(line_of<StoredSetting>("$120=10.000").value == 10.0);
  CHECK(line_of<Banner>("Grbl 1.1h ['$' for help]").version == "Grbl 1.1h");
  CHECK(line_of<Banner>("Grbl 0.9j ['$' for help]").number == 0.9);
  CHECK(line_of<Banner>("GrblHAL 1.1f ['$' or '$HELP' for help]").version == "GrblHAL 1.1f");
  for (const char* remark : {"", "[MSG:'$H'|'$X' to unlock]", ">G54:ok", "$74=SSID"})
    line_of<Remark>(remark);
}

TEST_CASE("What is cut or garbled is garbage, made printable") {
  for (const char* text :
       {"o", "error:", "error:1x", "ALARM:", "<Idle|MPos:1.000,2.000>", "<Idle|MPos:1.0,nan,2.0>",
        "<Lazy|MPos:0.000,0.000,0.000>", "<Idle|MPos:0.000,0.000,0.0", "$x=1", "Grbl", "Grbl x"})
    line_of<Garbage>(text);
  CHECK(line_of<Garbage>("\x81\x02ok").text == "..ok");
  CHECK(line_of<Garbage>(std::string(1000, 'x')).text.size() < 100);
}

TEST_CASE("No bytes make the parser fail") {
  std::mt19937 random(5);
  const std::string letters = "<>|:,.$=-0123456789MPosIdleGrblokALARMerror[]\x81 ";
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (std::size_t n = random() % 40; n > 0; --n) text += letters[random() % letters.size()];
    CHECK_FALSE(parse_line(text).valueless_by_exception());
  }
}

TEST_CASE("A jog names every axis to a thousandth of a millimetre and is never at rest") {
  CHECK(jog_line({1.0, -0.004, 20.5}, 8.0) == "$J=G21G53G90X1.000Y-0.004Z20.500F480.000");
  CHECK_THAT(jog_line({0.0, 0.0, -1e-9}, 0.0), Contains("Z0.000F1.000"));
}

TEST_CASE("Alarms and errors come in words with their numbers") {
  CHECK(alarm_words(1) == "alarm 1: a limit switch was hit");
  CHECK(error_words(15) == "error 15: the target lies beyond the soft limits ($130 to $132)");
  CHECK(error_words(777) == "error 777, which its maker's list explains");
}

TEST_CASE("Only scales that divide 1000 keep whole pulses") {
  for (const double kept : {1.0, 62.5, 125.0, 200.0, 250.0, 1000.0}) CHECK(keeps_pulses(kept));
  for (const double lost : {80.0, 160.0, 300.0, 1000.0 / 3.0, 2000.0})
    CHECK_FALSE(keeps_pulses(lost));
}

TEST_CASE("A board that matches the cell is accepted") {
  CHECK(refusal_of(suitable()).empty());
  Settings homing = suitable();
  homing[22] = 1;
  homing[23] = 7;
  CHECK(refusal_of(homing, HomeReference::kReverseSwitch).empty());
}

TEST_CASE("Every setting that differs from the cell is named with the command that mends it") {
  Settings settings = suitable();
  settings[101] = 80.0;
  settings[112] = 500.0;
  settings[120] = 10.0;
  settings[1] = 25.0;
  const std::string refusal = refusal_of(settings);
  CHECK_THAT(refusal, Contains("$101 is 80 (the cell's pulses_per_mm differs)"));
  CHECK_THAT(refusal, Contains("$112 is 500") && Contains("$120 is 10") && Contains("$1 is 25"));
  CHECK_THAT(refusal, Contains("send it $1=255 and $120=160 and $112=960 and $101=250"));
  settings = suitable();
  settings.erase(100);
  CHECK_THAT(refusal_of(settings), Contains("$100 is missing"));
  settings = suitable();
  settings[10] = 510.0;
  settings[13] = 1.0;
  CHECK_THAT(refusal_of(settings), Contains("$10=511 and $13=0"));
}

TEST_CASE("Home switches that the board does not look for, or elsewhere, are refused") {
  Settings settings = suitable();
  CHECK_THAT(refusal_of(settings, HomeReference::kForwardSwitch), Contains("$22=1"));
  settings[22] = 1.0;
  settings[23] = 2.0;
  CHECK_THAT(refusal_of(settings, HomeReference::kForwardSwitch), Contains("$23=0"));
  CHECK_THAT(refusal_of(settings, HomeReference::kReverseSwitch), Contains("$23=7"));
}

TEST_CASE("Firmware that is not supported is named by what it says, with the way on") {
  const auto named = [](const std::string& said) {
    const auto refusal = foreign_firmware(said);
    return refusal ? refusal->text() : "";
  };
  CHECK_THAT(named("[MSG:Grbl_ESP32 Ver 1.3a Date 20211103]\nGrbl 1.3a ['$' for help]\n"),
             Contains("has Grbl_ESP32"));
  CHECK_THAT(named("Grbl 0.9j ['$' for help]\n[0.9j.20160317:]\nok\n"),
             Contains("has a Grbl before 1.1") && Contains("cannot jog"));
  CHECK_THAT(named("start\necho:Marlin 2.1.2\n"), Contains("has Marlin"));
  CHECK_THAT(named("ok\nFIRMWARE_NAME:Smoothieware, FIRMWARE_URL:http\nok\n"),
             Contains("has Smoothieware"));
  CHECK_THAT(named(R"({"r":{"fv":0.97,"fb":440.20,"msg":"SYSTEM READY"},"f":[1,0,0]})"),
             Contains("has TinyG or g2core"));
  CHECK(named("Grbl 1.1h ['$' for help]\n[VER:1.1h.20190830:]\n[OPT:V,15,128]\nok\n").empty());
  CHECK(named("GrblHAL 1.1f ['$' or '$HELP' for help]\n[VER:1.1f.20260801:]\n"
              "[FIRMWARE:grblHAL]\n[DRIVER:ESP32]\nok\n")
            .empty());
  CHECK(is_supported(line_of<Banner>("GrblHAL 1.1f ['$' or '$HELP' for help]")));
  CHECK_FALSE(is_supported(line_of<Banner>("Grbl 1.2h ['$' for help]")));
}

}  // namespace
}  // namespace planar::grbl
