#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/hardware/drives/grbl_axes.h"
#include "planar_servo/hardware/drives/grbl_protocol.h"

namespace planar {

/// Drives three motors on one Grbl or grblHAL board, by GrblAxes. Opening resets the board and
/// refuses one whose settings differ from the cell's. No position is certain after opening, an
/// alarm or a reset, or once the board was out of touch.
class GrblDrives final : public DriveGroup {
 public:
  /// Opens the board; moves nothing. Throws DriveError with the remedy when it cannot be used.
  explicit GrblDrives(const GrblSettings& settings);

  /// Unlocks the board after an alarm, or ends a hold. status() says why one stays locked.
  void energize() override;
  /// The speeds hold for the next targets. The accelerations are the board's own; lower ones are
  /// ignored. Throws InputError for limits beyond the cell's.
  void set_limits(const std::array<DriveLimits, 3>& limits) override;
  /// As GrblAxes::go_to().
  void set_targets(const std::array<std::int32_t, 3>& targets_pulses) override;
  /// As GrblAxes::halt().
  void halt() override;
  std::array<DriveStatus, 3> status() override;
  /// The board searches for the switches of all axes at once; calling this for the other joints
  /// homes them without another search.
  void start_homing(int joint, HomeDirection direction) override;
  void set_position(int joint, std::int32_t position_pulses) override;
  void forget_positions() override;
  std::optional<std::string> stream_refusal() const override {
    return "a board with Grbl brakes to rest before it turns an axis back";
  }
  void reconnect() override;

 private:
  struct Joint {
    std::int32_t zero_pulses{0};  ///< the axis' pulses at which the joint's are 0
    bool certain{false};
    bool switch_found{false};  ///< by a search for another joint; it stands at `zero_pulses`
  };

  void open();
  void lose(const Refusal& why);
  void forget();
  bool in_touch() const { return axes_ != nullptr; }
  void require_touch(const std::string& purpose) const;
  /// Does something with the board. Throws DriveError when it is, or gets, out of touch.
  template <typename Deed>
  void command(const std::string& purpose, const Deed& deed);
  /// Reads the board's lines and updates the joints.
  void poll();
  void heed_axes();

  DriveStatus status_of(std::size_t joint) const;
  AxisPulses axis_pulses(const std::array<std::int32_t, 3>& joint_pulses) const;
  std::array<AxisLimits, 3> axis_limits() const;
  const GrblAxis& axis(std::size_t joint) const { return settings_.axes[joint]; }
  std::size_t index(std::size_t joint) const { return axis(joint).index(); }
  std::string name() const { return "the board at " + settings_.port; }

  GrblSettings settings_;
  std::unique_ptr<GrblAxes> axes_;
  Refusal error_;      ///< why the board is out of touch
  bool moved_{false};  ///< when it got out of touch
  std::array<Joint, 3> joints_;
  std::array<double, 3> speeds_pulses_s_{};
  int losses_{0};  ///< of the axes' position, as of the last update
  std::optional<std::size_t> homing_joint_;
};

}  // namespace planar
