#include "planar_servo/machine/cell_devices.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/plausibility.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_cell.h"

namespace planar {
namespace {

/// Judges by what a virtual cell knows of itself.
class TruthJudge final : public Judge {
 public:
  explicit TruthJudge(const std::shared_ptr<VirtualCell>& world) : world_(world) {}

  JudgeKind kind() const override { return JudgeKind::kTruth; }
  JudgedTip judge(const std::string& /*id*/, const Standing& /*standing*/) override {
    const TipPose tip = world_->true_tip();
    return {tip.p, 0.0, "", tip.phi};
  }
  double common_sigma() const override { return 0.0; }

 private:
  std::shared_ptr<VirtualCell> world_;
};

class OpenedDevices final : public CellDevices {
 public:
  OpenedDevices(const CellSettings& cell, const std::shared_ptr<VirtualCell>& world)
      : world_(world),
        camera_(cell.camera.kind->open(cell, world)),
        drives_(cell.drives[0].kind->open(cell, world)),
        tracker_(cell.tracker.kind->open(cell, world)) {}

  Clock& clock() override { return world_ ? world_->clock() : clock_; }
  FrameSource& camera() override { return *camera_; }
  DriveGroup& drives() override { return *drives_; }
  Tracker& tracker() override { return *tracker_; }
  BoardPresenter* board_presenter() override {
    return world_ ? &world_->board_presenter() : nullptr;
  }
  std::shared_ptr<Judge> truth() override {
    return world_ ? std::make_shared<TruthJudge>(world_) : nullptr;
  }

 private:
  std::shared_ptr<VirtualCell> world_;  ///< null for a real cell
  SteadyClock clock_;
  std::shared_ptr<FrameSource> camera_;
  std::shared_ptr<DriveGroup> drives_;
  std::shared_ptr<Tracker> tracker_;
};

void check_drives(const CellSettings& cell, Faults& faults) {
  const std::string file = cell.file.string();
  const DriveKind* first = cell.drives[0].kind;
  for (const DriveSettings& drive : cell.drives) {
    if (drive.kind != first)
      faults.add({fmt::format("drives have the kinds {} and {}", first->name(), drive.kind->name()),
                  "the three joints need drives of one kind", file});
    if (drive.kind->is_virtual() != cell.camera.kind->is_virtual())
      faults.add({fmt::format("camera.source is {}, but drives have the kind {}",
                              cell.camera.kind->name(), drive.kind->name()),
                  "a virtual camera needs virtual drives, and a real one real drives", file});
  }
}

}  // namespace

void require_devices(const CellSettings& cell) {
  Faults faults;
  const std::string file = cell.file.string();
  if (const auto refusal = cell.camera.kind->refusal()) throw InputError(refusal->at(file));
  check_drives(cell, faults);
  const bool is_virtual = cell.camera.kind->is_virtual();
  if (cell.tracker.kind->is_virtual() && !is_virtual)
    faults.add({fmt::format("tracker.source is {}, but camera.source is {}",
                            cell.tracker.kind->name(), cell.camera.kind->name()),
                "a virtual tracker measures in a virtual cell only", file});
  if (is_virtual && !cell.truth)
    faults.add({"lacks the key 'virtual'", "a virtual cell needs its truth file", file});
  faults.throw_if_any();
}

std::unique_ptr<CellDevices> open_cell(const CellSettings& cell) {
  require_devices(cell);
  warn_of_values(cell);
  std::shared_ptr<VirtualCell> world;
  if (cell.camera.kind->is_virtual())
    world = std::make_shared<VirtualCell>(read_truth(*cell.truth), virtual_hardware(cell));
  return std::make_unique<OpenedDevices>(cell, world);
}

}  // namespace planar
