#include "planar_servo/files/drawings/drawing.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/drawings/gcode.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

constexpr double kExact_m = 1e-9;

Drawing program(const std::string& text) {
  return read_gcode(text, "p.nc");
}

Path path_of_program(const std::string& text) {
  return path_of(program(text), 0.3, "p.nc");
}

bool is_at(const Eigen::Vector2d& p, double x_mm, double y_mm) {
  return (p - Eigen::Vector2d(x_mm, y_mm) * kMillimetre).norm() < kExact_m;
}

Eigen::Vector2d end_of(const Path& path) {
  return path.at(path.length_m()).pose.p;
}

TEST_CASE("A program's lines and arcs are gone as its words say") {
  const Path path = path_of_program(
      "%\n(a square, one corner round)\nN10 G21 G90 G17\nN20 G0 X300 Y-20\n"
      "N30 G1 X340 F600 ; along x\ng1y10\nG3 X330 Y20 I-10 J0\nG1 X300\nY-20\nM2\nX0 Y0\n");
  CHECK(is_at(path.at(0.0).pose.p, 300.0, -20.0));
  CHECK(is_at(end_of(path), 300.0, -20.0));
  CHECK(path.length_m() == Approx((40.0 + 30.0 + 5.0 * kPi + 30.0 + 40.0) * kMillimetre));
  CHECK(path.segments()[2].curvature() == Approx(1.0 / (10.0 * kMillimetre)));
  CHECK(is_at(path.at((70.0 + 2.5 * kPi) * kMillimetre).pose.p, 330.0 + 10.0 * std::sqrt(0.5),
              10.0 + 10.0 * std::sqrt(0.5)));
  CHECK(path.at(0.1).pose.phi == 0.3);
}

TEST_CASE("Arcs turn as G2 and G3 say, by centre or radius, long or short, and all round") {
  const auto sweep_of = [](const std::string& arc) {
    const Path path = path_of_program("G21 G90\nG0 X10 Y0\n" + arc);
    return path.length_m() / (10.0 * kMillimetre);
  };
  CHECK(sweep_of("G3 X0 Y10 I-10 J0") == Approx(0.5 * kPi));
  CHECK(sweep_of("G2 X0 Y10 I-10 J0") == Approx(1.5 * kPi));
  CHECK(sweep_of("G3 X0 Y10 R10") == Approx(0.5 * kPi));
  CHECK(sweep_of("G3 X0 Y10 R-10") == Approx(1.5 * kPi));
  CHECK(sweep_of("G2 X0 Y10 R10") == Approx(0.5 * kPi));
  CHECK(sweep_of("G3 I-10") == Approx(2.0 * kPi));
  const Path circle = path_of_program("G21 G90\nG0 X10 Y0\nG2 I-10");
  CHECK(is_at(circle.at(0.25 * circle.length_m()).pose.p, 0.0, -10.0));
  CHECK(is_at(end_of(circle), 10.0, 0.0));
}

TEST_CASE("Inches, steps, rests and feeds are taken as the program sets them") {
  const Drawing drawing = program("G20 G90 F60\nG0 X10 Y1\nG91 G1 X1\nG4 P1.5\nY-0.5\nG4 P0.5\n");
  const Path path = path_of(drawing, 0.0, "p.nc");
  CHECK(is_at(path.at(0.0).pose.p, 254.0, 25.4));
  CHECK(is_at(end_of(path), 279.4, 12.7));
  CHECK(path.rests_s() == std::vector<double>{1.5, 0.5});
  CHECK(drawing.speed_m_s.value() == Approx(25.4 * kMillimetre));
  CHECK(drawing.remarks.empty());
  CHECK_THAT(program("G1 X1 Y1\nX2").remarks.at(0), Contains("taken as millimetres"));
}

TEST_CASE("What others' programs say at their ends and of what holds anyway changes nothing") {
  const std::string plain = "G0 X300 Y0\nG2 X310 Y10 I0 J10 F600\nG1 X320\n";
  const double length_m = path_of_program("G21 G90\n" + plain).length_m();
  for (const char* beginning : {"\xEF\xBB\xBFG21 G90\n", "%\nO1001 (PART)\nG21 G90 G91.1 G61\n",
                                "G21 G90\nG64 P0.05\nM5\nM9\n"}) {
    INFO(beginning);
    CHECK(path_of_program(beginning + plain + "M05\nM9\nM2\n").length_m() == length_m);
    CHECK(is_gcode(beginning));
  }
  CHECK(path_of_program("G21 G90\nG0 X300 Y0\nG2 X310 Y10 I0 J10 K0.000 F600\nG1 X320\n")
            .length_m() == length_m);
  // The same feed in inches and millimetres.
  CHECK(program("G20 G90 F24\nG0 X10 Y1\nG21 F609.6\nG1 X300\n").speed_m_s.value() ==
        Approx(10.16 * kMillimetre));
}

TEST_CASE("The ends of a program's motions are targets, named by its line numbers") {
  const auto targets =
      targets_of(program("G21 G90\nN10 G0 X300 Y0\nN20 X310\nX320\nN20 Y5\n"), "p.nc");
  REQUIRE(targets.size() == 4);
  CHECK(targets[0].id == "N10");
  CHECK(targets[2].id == "line 4");
  CHECK(targets[3].id == "line 5");  // the program says N20 twice
  CHECK(is_at(targets[3].p_d, 320.0, 5.0));
}

TEST_CASE("What means nothing to a planar arm is refused by its line, all of it at once") {
  const std::pair<const char*, Refused> bad[] = {
      {"G1 X5 Z-2", Refused(Cause::kInvalid, "p.nc:3: moves Z")},
      {"M3 S1000", Refused(Cause::kInvalid, "p.nc:3: M3")},
      {"M0\nG1 X5", Refused(Cause::kInvalid, "p.nc:4: moves after M0")},
      {"G1 X5 (to the\nedge)", Refused(Cause::kInvalid, "p.nc:3: a comment")},
      {"M5\nG1 X5", Refused(Cause::kInvalid, "p.nc:4: moves after M5")},
      {"M9\nG3 X10 Y0 I-5", Refused(Cause::kInvalid, "p.nc:4: moves after M5 or M9")},
      {"G3 X0 Y10 I-10 K1", Refused(Cause::kInvalid, "p.nc:3: K1")},
      {"G28", Refused(Cause::kInvalid, "p.nc:3: G28")},
      {"G1 X#5", Refused(Cause::kInvalid, "p.nc:3: 'X'")},
      {"G1 X1,5", Refused(Cause::kInvalid, "p.nc:3")},
      {"G3 X10 Y10 I-10 J0.5", Refused(Cause::kContradiction, "radius")},
      {"G3 X40 Y0 R10", Refused(Cause::kInvalid, "radius 10.0000 mm")},
      {"G2 X5 Y5", Refused(Cause::kInvalid, "I, J or R")},
      {"G1 X5 I3", Refused(Cause::kContradiction, "I, J or R")},
      {"G1 X5 F60\nX6 F120", Refused(Cause::kContradiction, "p.nc:4: the feed")},
      {"G4", Refused(Cause::kInvalid, "p.nc:3: G4")},
      {"G4 P1 X5", Refused(Cause::kContradiction, "G4")},
      {"G1 X5 P1", Refused(Cause::kInvalid, "P without G4")},
      {"X5 X6", Refused(Cause::kExists, "has X")}};
  for (const auto& [line, refused] : bad) {
    INFO(line);
    CHECK_THROWS_MATCHES(program(std::string("G21 G90\nG0 X10 Y0\n") + line + "\n"), InputError,
                         refused);
  }
  CHECK_THROWS_MATCHES(program("G21 G90\nX5 Y5\n"), InputError,
                       Refused(Cause::kMissing, "G0 to G3"));
  for (const char* text : {"G21 G91\nG0 X5 Y5\n", "G21\nG2 X5 Y5 I1\n"})
    CHECK_THROWS_MATCHES(program(text), InputError, Refused(Cause::kMissing, "p.nc:2: begins"));
  for (const char* code : {"p.nc:2: M3", "p.nc:3: G33"})
    CHECK_THROWS_MATCHES(program("G21 G0 X1 Y1\nM3\nG33\n"), InputError,
                         Refused(Cause::kInvalid, code));
  CHECK_THROWS_MATCHES(path_of_program("G21\nG0 X5 Y5\n"), InputError,
                       Refused(Cause::kMissing, "p.nc"));
  CHECK_THROWS_MATCHES(targets_of(program("G21\n"), "p.nc"), InputError,
                       Refused(Cause::kMissing, "p.nc"));
}

TEST_CASE("A program may end with a stop, which its own line's motion comes before") {
  const Drawing drawing = program("G21 G90 (part (1)\nG0 X10 Y0\nG1 X5 M0\nG4 P1\nM2\n(open\n");
  REQUIRE(drawing.strokes.size() == 1);
  CHECK(is_at(drawing.strokes[0].back().p, 5.0, 0.0));
}

TEST_CASE("Ways that are none are left out, and places that no arm reaches are refused") {
  const Path path = path_of_program(
      "G21 G90\nG0 X300 Y0\nG1 X300.0001\nG3 X310 Y0 I5 J0\nG3 X310.004 Y0 I0.002 J0\nG1 X310 Y9\n"
      "G2 X320 Y9 R1000000\n");
  CHECK(path.length_m() == Approx((5.0 * kPi + 9.0 + 10.0) * kMillimetre).epsilon(1e-3));
  // An arc of 30 m radius, 40 um high, is gone straight within a micrometre.
  const Path flat = path_of_program("G21 G90\nG0 X300 Y0\nG3 X400 Y0 R30000\n");
  CHECK(flat.segments().size() == 7);
  for (double along_m = 0.0; along_m < 0.1; along_m += 0.001) {
    const Eigen::Vector2d p = flat.at(along_m).pose.p;
    // A circle about (0.35, h), h = sqrt(R^2 - c^2 / 4), below its chord.
    const double depth_m = std::sqrt(900.0 - 0.0025) - std::sqrt(900.0 - std::pow(p.x() - 0.35, 2));
    CHECK(p.y() == Approx(depth_m).margin(1.1e-6));
  }
  CHECK_THROWS_MATCHES(path_of_program("G20 G90\nG0 X300 Y0\nG1 X400\n"), InputError,
                       Refused(Cause::kUnreachable, "10.16 m"));
  CHECK_THROWS_MATCHES(targets_of(program("G21\nG0 X1000000 Y0\n"), "p.nc"), InputError,
                       Refused(Cause::kUnreachable, "p.nc"));
}

TEST_CASE("A program is told from a table by how it begins") {
  for (const char* text : {"%\n", " g0 X1", "N10 G1", "(part)", "; by hand", "F100"})
    CHECK(is_gcode(text));
  for (const char* text : {"x_mm,y_mm\n1,2\n", "", "# remark", "300,20", "Name,x"})
    CHECK_FALSE(is_gcode(text));
}

/// A DXF with these entities; `unit` is the number of $INSUNITS.
std::string dxf(const std::string& entities, int unit = 4) {
  return fmt::format(
      "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{}\n0\nENDSEC\n0\nSECTION\n2\n"
      "ENTITIES\n{}0\nENDSEC\n0\nEOF\n",
      unit, entities);
}

std::string line_entity(double x1, double y1, double x2, double y2,
                        const std::string& layer = "0") {
  return fmt::format("0\nLINE\n8\n{}\n10\n{}\n20\n{}\n11\n{}\n21\n{}\n", layer, x1, y1, x2, y2);
}

struct DxfFile {
  test::TemporaryFolder folder;

  Drawing read(const std::string& text, const DrawingSettings& settings = {}) const {
    return read_drawing(folder.write("part.dxf", text), settings);
  }
};

TEST_CASE("Lines that meet are one stroke, whichever way they were drawn") {
  const DxfFile file;
  const Drawing drawing = file.read(dxf(line_entity(300, 0, 340, 0) + line_entity(340, 30, 340, 0) +
                                        line_entity(340, 30.004, 300, 30)));
  REQUIRE(drawing.strokes.size() == 1);
  const Path path = path_of(drawing, 0.0, "part.dxf");
  CHECK(is_at(path.at(0.0).pose.p, 300.0, 0.0));
  CHECK(is_at(end_of(path), 300.0, 30.0));
  CHECK(drawing.remarks.empty());
}

TEST_CASE("Lines that meet are one stroke, in whatever order they were drawn") {
  const DxfFile file;
  const Drawing drawing =
      file.read(dxf(line_entity(310, 0, 320, 0) + line_entity(300, 0, 310, 0) +
                    line_entity(320, 0, 320, 10) + line_entity(300, 0, 300, 5)));
  REQUIRE(drawing.strokes.size() == 1);
  CHECK(drawing.remarks.empty());
  const Path path = path_of(drawing, 0.0, "");
  CHECK(path.length_m() == Approx(35.0 * kMillimetre));
  CHECK(is_at(path.at(0.0).pose.p, 300.0, 5.0));
  CHECK(is_at(end_of(path), 320.0, 10.0));
}

TEST_CASE("Parts that do not meet are joined by straight ways, which is said") {
  const DxfFile file;
  const Drawing drawing = file.read(dxf(line_entity(300, 0, 310, 0) + line_entity(400, 0, 390, 0) +
                                        "0\nCIRCLE\n8\n0\n10\n330\n20\n0\n40\n10\n"));
  REQUIRE(drawing.strokes.size() == 3);
  CHECK(is_at(drawing.strokes[1].front().p, 340.0, 0.0));  // the circle begins at angle 0
  CHECK(is_at(drawing.strokes[2].front().p, 390.0, 0.0));  // turned: its near end first
  CHECK_THAT(path_remarks(drawing).at(0), Contains("3 parts") && Contains("80.0 mm"));
  CHECK(path_of(drawing, 0.0, "").length_m() ==
        Approx((10.0 + 30.0 + 20.0 * kPi + 50.0 + 10.0) * kMillimetre));
}

TEST_CASE("Arcs and bulges of polylines are arcs") {
  const DxfFile file;
  const Drawing arc = file.read(dxf("0\nARC\n8\n0\n10\n300\n20\n0\n40\n10\n50\n90\n51\n0\n"));
  const Path long_way = path_of(arc, 0.0, "");
  CHECK(is_at(long_way.at(0.0).pose.p, 300.0, 10.0));
  CHECK(is_at(end_of(long_way), 310.0, 0.0));
  CHECK(long_way.length_m() == Approx(15.0 * kPi * kMillimetre));
  // A slot: two half circles, counterclockwise, and its sides.
  const Drawing slot = file.read(
      dxf("0\nLWPOLYLINE\n8\n0\n90\n4\n70\n1\n10\n300\n20\n0\n10\n320\n20\n0\n42\n1\n10\n320\n20\n"
          "10\n10\n300\n20\n10\n42\n1\n"));
  const Path around = path_of(slot, 0.0, "");
  CHECK(around.length_m() == Approx((40.0 + 10.0 * kPi) * kMillimetre));
  CHECK(is_at(around.at((20.0 + 2.5 * kPi) * kMillimetre).pose.p, 325.0, 5.0));
  CHECK(is_at(end_of(around), 300.0, 0.0));
}

TEST_CASE("Points are targets, and only chosen layers are read") {
  const DxfFile file;
  const std::string text =
      dxf("0\nPOINT\n8\nHOLES\n10\n300\n20\n5\n0\nPOINT\n8\nHOLES\n10\n310\n20\n5\n" +
          line_entity(0, 0, 1, 0, "FRAME") + "0\nSPLINE\n8\nFRAME\n0\nTEXT\n8\nHOLES\n1\nA\n");
  const Drawing drawing = file.read(text, {{"HOLES"}, {}});
  CHECK(drawing.strokes.empty());
  const auto targets = targets_of(drawing, "part.dxf");
  REQUIRE(targets.size() == 2);
  CHECK(targets[1].id == "P2");
  CHECK(is_at(targets[1].p_d, 310.0, 5.0));
  CHECK(drawing.remarks == std::vector<std::string>{"left out: 1 TEXT"});
  CHECK_THROWS_MATCHES(file.read(text), InputError,
                       Refused(Cause::kInvalid, "SPLINE on the layer FRAME"));
  CHECK_THROWS_MATCHES(file.read(text, {{"HOLE"}, {}}), InputError,
                       Refused(Cause::kMissing, "'HOLE'"));
}

TEST_CASE("Lines beside points that are targets need not meet") {
  const DxfFile file;
  const Drawing drawing = file.read(dxf("0\nPOINT\n8\n0\n10\n300\n20\n5\n" +
                                        line_entity(300, 0, 310, 0) + line_entity(400, 0, 390, 0)));
  CHECK(targets_of(drawing, "").size() == 1);
  CHECK(drawing.remarks.empty());
  CHECK(path_remarks(drawing).size() == 1);
}

TEST_CASE("What a drawing does not show is not gone, unless its layer is asked for") {
  const DxfFile file;
  const auto layer = [](const char* name, int color, int flags) {
    return fmt::format("0\nLAYER\n2\n{}\n70\n{}\n62\n{}\n", name, flags, color);
  };
  const std::string text =
      "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n" + layer("OFF", -7, 0) + layer("FROZEN", 7, 1) +
      layer("SHOWN", 7, 4) + "0\nENDTAB\n0\nENDSEC\n" +
      dxf(line_entity(300, 0, 310, 0, "SHOWN") + line_entity(310, 0, 310, 50, "OFF") +
          line_entity(310, 0, 310, 60, "FROZEN") + line_entity(310, 0, 310, 70, "SHOWN") +
          "60\n1\n");
  const Drawing drawing = file.read(text);
  CHECK(path_of(drawing, 0.0, "").length_m() == Approx(10.0 * kMillimetre));
  CHECK(drawing.remarks ==
        std::vector<std::string>{"left out: 1 LINE on the layer FROZEN, which is off or frozen",
                                 "left out: 1 LINE on the layer OFF, which is off or frozen",
                                 "left out: 1 invisible LINE"});
  CHECK(path_of(file.read(text, {{"OFF"}, {}}), 0.0, "").length_m() == Approx(50.0 * kMillimetre));
}

TEST_CASE("Lines lie where they are drawn, and what is drawn aslant or from below is refused") {
  const DxfFile file;
  const Drawing line = file.read(dxf(line_entity(300, 0, 310, 0) + "230\n-1.0\n"));
  CHECK(is_at(end_of(path_of(line, 0.0, "")), 310.0, 0.0));
  const std::string circle = "0\nCIRCLE\n8\n0\n10\n300\n20\n0\n40\n10\n210\n0\n220\n1\n230\n0\n";
  CHECK_THROWS_MATCHES(file.read(dxf(circle)), InputError, Refused(Cause::kInvalid, "aslant"));
}

TEST_CASE("Only a DXF has layers and a unit to be chosen") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("part.nc", "G90\nG0 X10 Y1\nG1 X12\n");
  CHECK(read_drawing(path).strokes.size() == 1);
  CHECK_THROWS_MATCHES(read_drawing(path, {{}, kInch}), InputError,
                       Refused(Cause::kInvalid, "part.nc: is no DXF"));
  CHECK_THROWS_MATCHES(read_drawing(path, {{"HOLES"}, {}}), InputError,
                       Refused(Cause::kInvalid, "part.nc: is no DXF"));
}

TEST_CASE("A layer is found by its name however the drawing writes letters") {
  const DxfFile file;
  for (const char* written : {"B\xF6hrung 3", "B\xC3\xB6hrung 3"})
    CHECK(file.read(dxf(line_entity(300, 0, 310, 0, written)), {{"B\xC3\xB6hrung 3"}, {}})
              .strokes.size() == 1);
}

TEST_CASE("A drawing's unit is its header's, and asked for where that has none") {
  const DxfFile file;
  const std::string line = line_entity(10, 0, 11, 0);
  CHECK(path_of(file.read(dxf(line, 1)), 0.0, "").length_m() == Approx(25.4 * kMillimetre));
  CHECK(path_of(file.read(dxf(line, 5)), 0.0, "").length_m() == Approx(10.0 * kMillimetre));
  CHECK_THROWS_MATCHES(file.read(dxf(line, 0)), InputError, Refused(Cause::kMissing, "$INSUNITS"));
  CHECK_THROWS_MATCHES(file.read(dxf(line, 13)), InputError,
                       Refused(Cause::kInvalid, "13 of $INSUNITS"));
  CHECK(path_of(file.read(dxf(line, 0), {{}, kMillimetre}), 0.0, "").length_m() ==
        Approx(kMillimetre));
  const Drawing other = file.read(dxf(line, 4), {{}, kInch});
  CHECK(path_of(other, 0.0, "").length_m() == Approx(kInch));
  CHECK_THAT(other.remarks.at(0), Contains("a unit of 1 mm; 25.4 mm are taken as asked"));
}

TEST_CASE("What is no drawing, or a torn one, is refused where it is") {
  const DxfFile file;
  const std::string line = line_entity(0, 0, 1, 0), whole = dxf(line);
  CHECK_THROWS_MATCHES(file.read(""), InputError, Refused(Cause::kMissing, "part.dxf: "));
  CHECK_THROWS_MATCHES(file.read("x_mm,y_mm\n1,2\n"), InputError,
                       Refused(Cause::kInvalid, "part.dxf:1: 'x_mm,y_mm'"));
  CHECK_THROWS_MATCHES(file.read(whole.substr(0, whole.find("11\n1\n"))), InputError,
                       Refused(Cause::kInvalid, "part.dxf: "));
  CHECK_THROWS_MATCHES(file.read(dxf(line + "0\nLINE\n8\n0\n10\nabc\n20\n1\n11\n1\n21\n1\n")),
                       InputError, Refused(Cause::kInvalid, "part.dxf:32: 'abc'"));
  CHECK_THROWS_MATCHES(file.read(dxf("0\nCIRCLE\n8\n0\n10\n1\n20\n1\n")), InputError,
                       Refused(Cause::kMissing, "group 40"));
  CHECK_THROWS_MATCHES(file.read(dxf("0\nARC\n8\n0\n230\n-1.0\n")), InputError,
                       Refused(Cause::kInvalid, "ARC is drawn from below"));
}

TEST_CASE("The corners of an old polyline are entities of their own") {
  const DxfFile file;
  const Drawing drawing = file.read(dxf(
      "0\nPOLYLINE\n8\n0\n66\n1\n70\n0\n0\nVERTEX\n8\n0\n10\n300\n20\n0\n42\n1\n0\nVERTEX\n8\n0\n"
      "10\n320\n20\n0\n0\nSEQEND\n" +
      line_entity(320, 0, 330, 0)));
  CHECK(path_of(drawing, 0.0, "").length_m() == Approx((10.0 * kPi + 10.0) * kMillimetre));
}

TEST_CASE("Of a splined polyline only the curve is gone, and a mesh is none") {
  const DxfFile file;
  const auto polyline = [](int flags) {
    return dxf(fmt::format(
        "0\nPOLYLINE\n8\n0\n66\n1\n70\n{}\n0\nVERTEX\n8\n0\n10\n300\n20\n90\n70\n16\n0\nVERTEX\n"
        "8\n0\n10\n300\n20\n0\n70\n8\n0\nVERTEX\n8\n0\n10\n320\n20\n0\n70\n8\n0\nSEQEND\n",
        flags));
  };
  CHECK(path_of(file.read(polyline(4)), 0.0, "").length_m() == Approx(20.0 * kMillimetre));
  CHECK_THROWS_MATCHES(file.read(polyline(64)), InputError, Refused(Cause::kInvalid, "POLYLINE"));
}

}  // namespace
}  // namespace planar
