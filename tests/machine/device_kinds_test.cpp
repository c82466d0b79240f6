#include "planar_servo/machine/device_kinds.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/fields.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/manual_clock.h"
#include "support/mock_pulse_drive.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

struct MadeUpDetails final : DeviceDetails {
  int ratchet_teeth{0};
};

/// A drive that nobody sells, with a key of its own. It shows what a new kind has to bring.
class MadeUpKind final : public DriveKind {
 public:
  std::string name() const override { return "made_up"; }
  bool is_virtual() const override { return true; }
  void read(Fields& drive, CellSettings& cell, std::size_t joint) const override {
    const auto details = std::make_shared<MadeUpDetails>();
    drive.whole_number("ratchet_teeth", details->ratchet_teeth, 3, 100);
    cell.drives[joint].details = details;
  }
  std::shared_ptr<DriveGroup> open(const CellSettings& /*cell*/) const override {
    return std::make_shared<SeparateDrives>(std::array<PulseDrive*, 3>{&mock_, &mock_, &mock_});
  }
  std::vector<Finding> examine(const CellSettings& /*cell*/) const override { return {}; }

 private:
  mutable test::ManualClock clock_;
  mutable test::MockPulseDrive mock_{clock_};
};

std::string cell_with_made_up_drives(const std::string& teeth) {
  std::string text = read_file(test::paper_cell_file());
  const std::string from = "{kind: virtual,", to = "{kind: made_up, ratchet_teeth: " + teeth + ",";
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from))
    text.replace(at, from.size(), to);
  return text;
}

TEST_CASE("A new kind of drive reads its own keys and is opened, and nothing else knows of it") {
  const test::TemporaryFolder folder;
  folder.write("truth.yaml", read_file(test::paper_cell_file().parent_path() / "truth.yaml"));
  const MadeUpKind made_up;
  DeviceKinds kinds = device_kinds();
  kinds.drives.push_back(&made_up);
  const CellSettings cell =
      read_cell(folder.write("cell.yaml", cell_with_made_up_drives("17")), kinds);
  CHECK(cell.drives[2].kind == &made_up);
  CHECK(static_cast<const MadeUpDetails&>(*cell.drives[2].details).ratchet_teeth == 17);
  const auto devices = open_cell(cell);
  CHECK_NOTHROW(devices->drives().status());
  CHECK_THROWS_MATCHES(read_cell(folder.write("bad.yaml", cell_with_made_up_drives("1")), kinds),
                       InputError, test::Refused(Cause::kInvalid, "drives[0].ratchet_teeth"));
}

TEST_CASE("Every kind has a name of its own") {
  const DeviceKinds& kinds = device_kinds();
  const auto names_differ = [](const auto& of_one_sort) {
    for (std::size_t i = 0; i < of_one_sort.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        if (of_one_sort[i]->name() == of_one_sort[k]->name()) return false;
    return !of_one_sort.empty();
  };
  CHECK(names_differ(kinds.cameras));
  CHECK(names_differ(kinds.drives));
  CHECK(names_differ(kinds.trackers));
}

TEST_CASE("The udev rules keep ModemManager off the whole device of each port that they open") {
  const auto root = test::paper_cell_file().parent_path().parent_path().parent_path();
  std::istringstream rules(read_file(root / "tools/70-planar-servo.rules"));
  const auto makers_in = [](const std::string& rule) {
    const std::string key = "idVendor}==\"";
    const std::size_t begin = rule.find(key) + key.size();
    return rule.substr(begin, rule.find('"', begin) - begin);
  };
  std::string opened, ignored;
  for (std::string rule; std::getline(rules, rule);) {
    if (rule.rfind("SUBSYSTEM==\"tty\"", 0) == 0) opened = makers_in(rule);
    if (rule.find("ID_MM_DEVICE_IGNORE") == std::string::npos) continue;
    CHECK_THAT(rule, Catch::Contains("SUBSYSTEM==\"usb\", ENV{DEVTYPE}==\"usb_device\""));
    ignored = makers_in(rule);
  }
  CHECK_THAT(opened, Catch::Contains("067b"));
  CHECK(ignored == opened);
}

}  // namespace
}  // namespace planar
