#include "planar_servo/files/cell_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/hardware/cameras/aravis_kind.h"
#include "planar_servo/hardware/drives/drive_kinds.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

TEST_CASE("The paper's cell is read in SI") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  CHECK(cell.camera.width_px == 5120);
  CHECK(cell.camera.pixel_pitch_m.value() == Approx(2.5e-6));
  CHECK(cell.arm.geometry.link_lengths_m == Eigen::Vector2d(0.3, 0.3));
  CHECK(cell.transmission.drives[2].gear_ratio == 50.0);
  CHECK(cell.transmission.drives[0].max_speed_rad_s == Approx(60.0 * kDegree));
  CHECK(cell.lamps.layout.separation_m == Approx(0.04));
  CHECK(cell.servo.tolerance_m == Approx(5e-6));
  CHECK(cell.servo.settle_s == Approx(0.2));
  CHECK(cell.datum.size() == 3);
  CHECK(cell.workspace.radius_max_m == Approx(0.54));
  REQUIRE(cell.truth.has_value());
  CHECK(cell.truth->filename() == "truth.yaml");
}

/// Reads the paper's cell with `from` replaced by `to`.
CellSettings read_with(const std::string& from, const std::string& to) {
  const test::TemporaryFolder folder;
  return read_cell(
      folder.write("cell.yaml", test::replaced(read_file(test::paper_cell_file()), from, to)));
}

std::string with_aravis_camera(const std::string& keys) {
  return test::replaced(read_file(test::paper_cell_file()), "source: virtual,",
                        "source: aravis, " + keys);
}

TEST_CASE("A camera of source aravis has an address or a serial number, and settings in SI") {
  const test::TemporaryFolder folder;
  const AravisSettings gige = aravis_settings(
      read_cell(folder.write("gige.yaml",
                             with_aravis_camera("address: 192.168.0.2, exposure_us: 2500, gain_db: "
                                                "6, pixel_format: Mono10p, trigger: software, "
                                                "packet_size: 9000,")))
          .camera);
  CHECK(gige.address == "192.168.0.2");
  CHECK(gige.id.empty());
  CHECK(gige.exposure_s == Approx(2.5e-3));
  CHECK(gige.gain_db == 6.0);
  CHECK(gige.pixel_format == PixelFormat::kMono10p);
  CHECK(gige.trigger == CameraTrigger::kSoftware);
  CHECK(gige.packet_size == 9000);
  const AravisSettings usb = aravis_settings(
      read_cell(folder.write("usb.yaml",
                             with_aravis_camera("id: FCN24010001, exposure_us: 100, gain_db: 0, "
                                                "pixel_format: Mono8, trigger: free_run,")))
          .camera);
  CHECK(usb.address.empty());
  CHECK(usb.id == "FCN24010001");
  CHECK(usb.packet_size == 0);
}

TEST_CASE("Settings that no camera has are refused in the cell file") {
  const test::TemporaryFolder folder;
  const auto file =
      folder.write("cell.yaml", with_aravis_camera("exposure_us: 0, gain_db: 0, pixel_format: "
                                                   "RGB8, trigger: often, packet_size: 70000,"));
  for (const char* key : {"camera.exposure_us", "camera.pixel_format", "'RGB8'", "Mono12Packed",
                          "camera.trigger", "camera.packet_size"})
    CHECK_THROWS_MATCHES(read_cell(file), InputError, Refused(Cause::kInvalid, key));
  CHECK_THROWS_MATCHES(read_with("source: virtual,", "source: virtual, trigger: software,"),
                       InputError, Refused(Cause::kInvalid, "'camera.trigger'"));
}

TEST_CASE("Faults of a cell file are told all at once, each with its place and rule") {
  const test::TemporaryFolder folder;
  std::string text = read_file(test::paper_cell_file());
  text = test::replaced(text, "gain: 1.0", "gain: 1.5");
  text = test::replaced(text, "settle_ms", "setle_ms");
  text = test::replaced(text, "positive_rotation: clockwise", "positive_rotation: left");
  text = test::replaced(text, "[300.0, 300.0]", "[300.0, -1]");
  text = test::replaced(text, "sigma_mm: 0.010", "sigma_mm: .nan");
  const auto file = folder.write("cell.yaml", text);
  for (const char* key : {"servo.gain", "'servo.setle_ms'", "arm.positive_rotation",
                          "arm.link_lengths_mm[1]", "tracker.sigma_mm"})
    CHECK_THROWS_MATCHES(read_cell(file), InputError, Refused(Cause::kInvalid, key));
  CHECK_THROWS_MATCHES(read_cell(file), InputError, Refused(Cause::kMissing, "'settle_ms'"));
}

TEST_CASE("Tools are a map of names to files") {
  const test::TemporaryFolder folder;
  const std::string text = read_file(test::paper_cell_file());
  const auto line = std::count(text.begin(), text.end(), '\n') + 1;
  for (const auto& [tools, column] : {std::pair("[needle.yaml]", 8), std::pair("needle.yaml", 8),
                                      std::pair("", 1), std::pair("{needle: 5}", 17)}) {
    const auto file = folder.write("cell.yaml", fmt::format("{}tools: {}\n", text, tools));
    CHECK_THROWS_MATCHES(
        read_cell(file), InputError,
        Refused(Cause::kInvalid, *tools == '\0' ? "tools is empty"
                                                : fmt::format("cell.yaml:{}:{}: ", line, column)));
  }
  const auto good = folder.write("cell.yaml", text + "tools: {needle: needle.yaml}\n");
  CHECK(read_cell(good).tools.at("needle") == folder.path() / "needle.yaml");
}

TEST_CASE("A fault of an obstacle is told once, by its own place, key and value") {
  const test::TemporaryFolder folder;
  const auto refusals = [&](const std::string& width, const std::string& obstacle) {
    std::string text = read_file(test::paper_cell_file());
    text = test::replaced(text, "elbow:", "link_width_mm: [60, " + width + "], elbow:");
    text = test::replaced(text, "keep_out: []", "obstacles: [" + obstacle + "], keep_out: []");
    try {
      read_cell(folder.write("cell.yaml", text));
    } catch (const InputError& e) {
      return e.refusals();
    }
    return std::vector<Refusal>();
  };
  CHECK(refusals("60", "{name: post, x_mm: -300, y_mm: 300, radius_mm: 50}").empty());
  for (const auto& [obstacle, said] :
       {std::pair("polygon_mm: [[-10, 0], [10, 0]]", "polygon_mm has 2 corners"),
        std::pair("x_mm: 0, y_mm: 0, radius_mm: 50, z_mm: [80, 20]", "z_mm is [80, 20]"),
        std::pair("x_mm: 0, radius_mm: 50", "lacks the key 'y_mm'"),
        std::pair("x_mm: 0, y_mm: 0, radius_mm: 50", "post reaches over the base's axis")}) {
    const std::vector<Refusal> told = refusals("60", fmt::format("{{name: post, {}}}", obstacle));
    REQUIRE(told.size() == 1);
    CHECK_THAT(told[0].fault, Contains(said));
    CHECK(told[0].where.find(":1:1") == std::string::npos);
  }
  CHECK(refusals("-60", "{name: post, x_mm: -300, y_mm: 300, radius_mm: 50}")
            .front()
            .fault.find("link_width_mm[1]") != std::string::npos);
}

TEST_CASE("A Tic has a serial number of its own, a command timeout and a home") {
  const test::TemporaryFolder folder;
  std::string text = read_file(test::paper_cell_file());
  const auto tic = [&text](const std::string& keys) {
    text = test::replaced(text, "{kind: virtual, pulses", "{kind: tic, " + keys + ", pulses");
  };
  tic("serial: '00411111', command_timeout_ms: 250, home: {reference: reverse_switch, at_deg: "
      "-90}");
  tic("serial: '00422222', command_timeout_ms: 250, home: {reference: taught, at_deg: 10}");
  const CellSettings cell = read_cell(folder.write("cell.yaml", text));
  CHECK(cell.drives[0].kind->name() == "tic");
  CHECK(tic_settings(cell.drives[0]).serial == "00411111");
  CHECK(tic_settings(cell.drives[1]).command_timeout_s == Approx(0.25));
  CHECK(cell.transmission.drives[0].home == HomeReference::kReverseSwitch);
  CHECK(cell.transmission.drives[0].home_rad == Approx(-kPi / 2.0));
  CHECK(cell.transmission.drives[1].home == HomeReference::kTaught);
  CHECK(cell.drives[2].kind->name() == "virtual");

  tic("serial: '00411111', command_timeout_ms: 0, home: {reference: hall}");
  const auto file = folder.write("cell.yaml", text);
  CHECK_THROWS_MATCHES(read_cell(file), InputError,
                       Refused(Cause::kExists, "'00411111' of drives[0]"));
  for (const char* value : {"command_timeout_ms is 0", "'hall'"})
    CHECK_THROWS_MATCHES(read_cell(file), InputError, Refused(Cause::kInvalid, value));
  CHECK_THROWS_MATCHES(read_cell(file), InputError, Refused(Cause::kMissing, "'at_deg'"));
}

TEST_CASE("A misspelt source or kind is one fault, whatever else stands beside it") {
  const auto misspelt_source = [] {
    read_with("source: virtual,", "source: aravi, address: 10.0.0.2, trigger: software,");
  };
  CHECK_THROWS_MATCHES(misspelt_source(), InputError, Refused(Cause::kInvalid, "camera.source"));
  CHECK_THROWS_WITH(misspelt_source(), !Contains("\n"));
  const auto misspelt_kind = [] {
    read_with("{kind: virtual, pulses", "{kind: tik, serial: '1', pulses");
  };
  CHECK_THROWS_MATCHES(misspelt_kind(), InputError, Refused(Cause::kInvalid, "drives[0].kind"));
  CHECK_THROWS_WITH(misspelt_kind(), !Contains("\n"));
}

TEST_CASE("A malformed limit is one fault that shows what stands in the file") {
  CHECK_THROWS_MATCHES(read_with("[-175, 175]", "[-175, wide]"), InputError,
                       Refused(Cause::kInvalid, "joint_limits_deg[1][1] is 'wide'"));
  CHECK_THROWS_WITH(read_with("[-175, 175]", "[-175, wide]"), !Contains("\n"));
}

TEST_CASE("Whole numbers are not cut to size") {
  CHECK_THROWS_MATCHES(read_with("width_px: 5120", "width_px: 1280.7"), InputError,
                       Refused(Cause::kInvalid, "camera.width_px is 1280.7"));
  CHECK_THROWS_MATCHES(read_with("max_iterations: 12", "max_iterations: 2.9"), InputError,
                       Refused(Cause::kInvalid, "servo.max_iterations is 2.9"));
}

TEST_CASE("No lamp is smaller than nothing, and no arm takes longer than a minute to settle") {
  CHECK_THROWS_MATCHES(read_with("diameter_mm: [8.0, 8.0]", "diameter_mm: [8.0, -8.0]"), InputError,
                       Refused(Cause::kInvalid, "lamps.diameter_mm[1]"));
  CHECK_THROWS_MATCHES(read_with("settle_ms: 200", "settle_ms: 1e300"), InputError,
                       Refused(Cause::kInvalid, "servo.settle_ms"));
}

TEST_CASE("What only a data sheet knows of the sensor may be left out, but must make sense") {
  CHECK_NOTHROW(read_with("pixel_pitch_um: 2.5,", ""));
  CHECK_NOTHROW(read_with(", gain_e_per_level: 18.6", ""));
  CHECK_THROWS_MATCHES(read_with("gain_e_per_level: 18.6", "gain_e_per_level: -1"), InputError,
                       Refused(Cause::kInvalid, "camera.gain_e_per_level"));
}

TEST_CASE("A cell says how lamps' centres are measured, or leaves it at auto") {
  const test::TemporaryFolder folder;
  CHECK(read_cell(test::paper_cell_file()).lamps.method == CenterMethod::kAuto);
  const std::string text = test::replaced(read_file(test::paper_cell_file()), "separation_mm: 40.0",
                                          "separation_mm: 40.0, method: vpdot2");
  CHECK(read_cell(folder.write("cell.yaml", text)).lamps.method == CenterMethod::kVpDot2);
  CHECK_THROWS_MATCHES(read_with("separation_mm: 40.0", "separation_mm: 40.0, method: guess"),
                       InputError, Refused(Cause::kInvalid, "lamps.method"));
}

TEST_CASE("A cell may name lamps that are fixed to its base, with their places or without") {
  const test::TemporaryFolder folder;
  CHECK(read_cell(test::paper_cell_file()).reference_lamps.empty());
  const std::string text = read_file(test::paper_cell_file());
  const auto with = [&](const std::string& items) {
    return folder.write("cell.yaml", text + "reference_lamps: [" + items + "]\n");
  };
  const std::string others = ", {id: R2, diameter_mm: 8}, {id: R3, diameter_mm: 8}";
  const auto lamps =
      read_cell(with("{id: R1, diameter_mm: 6, x_mm: 500, y_mm: -20}" + others)).reference_lamps;
  REQUIRE(lamps.size() == 3);
  CHECK(lamps[0].id == "R1");
  CHECK(lamps[0].diameter_m == Approx(0.006));
  REQUIRE(lamps[0].p_B.has_value());
  CHECK(lamps[0].p_B->isApprox(Eigen::Vector2d(0.5, -0.02)));
  CHECK_FALSE(lamps[1].p_B.has_value());
  CHECK_THROWS_MATCHES(read_cell(with("{id: R1, diameter_mm: 6, x_mm: 500}" + others)), InputError,
                       Refused(Cause::kMissing, "'y_mm'"));
  CHECK_THROWS_MATCHES(read_cell(with("{id: R3, diameter_mm: 6}" + others)), InputError,
                       Refused(Cause::kExists, "'R3'"));
  CHECK_THROWS_MATCHES(read_cell(with("{id: R3, diameter_mm: 6}")), InputError,
                       Refused(Cause::kInsufficient, "reference_lamps"));
}

TEST_CASE("A cell has the tracker of its kind unless it names another") {
  const test::TemporaryFolder folder;
  CHECK(read_cell(test::paper_cell_file()).tracker.kind->name() == "virtual");
  const std::string text =
      test::replaced(read_file(test::paper_cell_file()), "tracker: {", "tracker: {source: none, ");
  CHECK(read_cell(folder.write("cell.yaml", text)).tracker.kind->name() == "none");
}

TEST_CASE("A deviation is asked of a tracker, and where there is none of nobody") {
  const std::string stated = "tracker: {sigma_mm: 0.010, sigma_mm_per_m: 0.0, bias_mm: 0.002}";
  CHECK_FALSE(read_with(stated, "tracker: {source: none}").tracker.kind->measures());
  for (const char* key : {"'sigma_mm'", "'sigma_mm_per_m'"})
    CHECK_THROWS_MATCHES(read_with(stated, "tracker: {source: ask}"), InputError,
                         Refused(Cause::kMissing, key));
}

TEST_CASE("A cell may state its tracker's systematic error") {
  CHECK(*read_cell(test::paper_cell_file()).tracker.bias_m == Approx(2e-6));
  const test::TemporaryFolder folder;
  const std::string text =
      test::replaced(read_file(test::paper_cell_file()), ", bias_mm: 0.002", "");
  CHECK_FALSE(read_cell(folder.write("cell.yaml", text)).tracker.bias_m);
  CHECK_THROWS_MATCHES(read_with("bias_mm: 0.002", "bias_mm: -1"), InputError,
                       Refused(Cause::kInvalid, "tracker.bias_mm"));
}

TEST_CASE("A file that is not made yet is named with the program that makes it") {
  for (const char* name : {"/absent/camera.yaml: ", "planar-calibrate-camera"})
    CHECK_THROWS_MATCHES(require_belonging(missing_files({{Role::kCamera, "/absent/camera.yaml"}})),
                         InputError, Refused(Cause::kMissing, name));
}

}  // namespace
}  // namespace planar
