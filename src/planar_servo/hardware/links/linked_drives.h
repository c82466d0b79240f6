#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "planar_servo/hardware/links/machine_link.h"

namespace planar {

/// Drives three motors through the link to a controller that moves them. Positions are certain from
/// the homing or the declaration of a joint until the link is opened again, the machine says that
/// it is lost, its counts change at rest, or it is out of touch.
class LinkedDrives final : public DriveGroup {
 public:
  using Open = std::function<std::unique_ptr<MachineLink>()>;

  /// Opens the link; moves nothing. `name` is that of the machine in messages, `rated` the limits
  /// of the cell's motors. A rest within `in_position` counts of a target is that target. Throws
  /// DriveError when it cannot be used.
  LinkedDrives(std::string name, const std::array<DriveLimits, 3>& rated, Open open,
               int in_position = 0);
  /// Brakes what moves.
  ~LinkedDrives() override;
  LinkedDrives(const LinkedDrives&) = delete;
  LinkedDrives& operator=(const LinkedDrives&) = delete;

  void energize() override;
  /// Throws InputError for limits beyond the cell's.
  void set_limits(const std::array<DriveLimits, 3>& limits) override;
  /// Brakes to rest first what moves. Throws DriveError unless all positions are certain.
  void set_targets(const std::array<std::int32_t, 3>& targets_pulses) override;
  /// These brake to rest and wait for it; the positions stay certain. They throw DriveError when
  /// the machine got out of touch in a move.
  void brake_towards(const std::array<std::int32_t, 3>& /*targets_pulses*/) override { halt(); }
  void halt() override;
  std::array<DriveStatus, 3> status() override;
  void start_homing(int joint, HomeDirection direction) override;
  void set_position(int joint, std::int32_t position_pulses) override;
  void forget_positions() override;
  std::optional<std::string> stream_refusal() const override {
    return name_ + " moves from rest to rest";
  }
  void reconnect() override;

 private:
  struct Joint {
    std::int32_t zero{0};  ///< the machine's count at which the joint's pulses are 0
    bool certain{false};
  };

  void open();
  void lose(const Refusal& why);
  /// Does something with the machine. Throws DriveError when it is, or gets, out of touch.
  template <typename Deed>
  void command(const std::string& purpose, const Deed& deed);
  void read();
  void take(const MachineState& state);
  void forget(const std::string& why);
  /// Notes whether the machine stands elsewhere than it rested.
  void check_rest();
  /// Notes where the machine came to rest beside its target.
  void judge_rest();
  void brake_to_rest();
  /// Throws DriveError that says why the machine cannot be sent anywhere, if it cannot.
  void require_ready() const;
  DriveStatus status_of(std::size_t joint) const;

  std::string name_;
  std::array<DriveLimits, 3> rated_, limits_;
  Open open_;
  std::unique_ptr<MachineLink> link_;
  Refusal error_;  ///< why the machine is out of touch
  MachineState state_;
  std::optional<Pulses> goal_;  ///< until it was seen at rest there
  Pulses from_{0, 0, 0};        ///< where it was as it was sent there
  std::string missed_;          ///< how it came to rest elsewhere than it should
  bool was_on_{false};          ///< since it was switched on, in touch all the time
  int in_position_;
  std::optional<Pulses> held_;  ///< the target at which it rests
  std::optional<Pulses> rest_;  ///< where it rests until it is told to move
  std::array<Joint, 3> joints_;
  std::optional<std::size_t> homing_joint_;
};

}  // namespace planar
