#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"

namespace planar {

class DriveGroup;
class Fields;
class FrameSource;
class Tracker;
struct CellSettings;

/// The remedy where a user may not open a device.
constexpr char kInstallRules[] =
    "install the udev rules by the package planar-servo (or sudo cmake --install build/release)";

/// Says how one part of a cell was found, and the remedy if it is not well.
struct Finding : Refusal {  ///< `fault` says what was found, `where` is the part, such as "drive 2"
  enum class Verdict { kWell, kDoubtful, kFaulty };
  Verdict verdict{Verdict::kWell};
};

/// Returns a refusal as a fault of `subject`, with the remedy `otherwise` where it names none.
inline Finding faulty(const std::string& subject, const Refusal& refusal,
                      const std::string& otherwise = "") {
  return {{Refusal{refusal.fault, "", refusal.where}.text(),
           refusal.remedy.empty() ? otherwise : refusal.remedy, subject, refusal.cause},
          Finding::Verdict::kFaulty};
}

/// Base of the settings that only one kind of device has, and alone reads.
struct DeviceDetails {
  virtual ~DeviceDetails() = default;
};

/// Base of all kinds of devices. A cell file names its kind.
class DeviceKind {
 public:
  virtual ~DeviceKind() = default;

  /// Returns the name of this kind in a cell file.
  virtual std::string name() const = 0;

  /// Returns true for devices of a virtual cell. Virtual and real devices do not mix.
  virtual bool is_virtual() const { return false; }

  /// Says how a cell's devices of this kind are. It moves nothing and switches nothing on.
  virtual std::vector<Finding> examine(const CellSettings& cell) const = 0;
};

/// One kind of camera, with its own keys of a cell file's `camera` block.
class CameraKind : public DeviceKind {
 public:
  /// Returns why no camera of this kind can be opened and what to do instead; empty when one can.
  virtual std::optional<Refusal> refusal() const { return std::nullopt; }

  /// Reads the keys that only this kind has. Faults go to the document.
  virtual std::shared_ptr<const DeviceDetails> read(Fields& /*camera*/) const { return nullptr; }

  /// Opens a cell's camera, unless it is virtual. Throws WorkError when it does not answer, and
  /// InputError for settings that it cannot have.
  virtual std::shared_ptr<FrameSource> open(const CellSettings& /*cell*/) const { return nullptr; }
};

/// One kind of drive, with its own keys of an item of `drives`. A cell's three are of one kind.
class DriveKind : public DeviceKind {
 public:
  /// Returns the lines of an item of `drives` in a new cell file that hold the keys which only this
  /// kind has, indented by four, each with a comment. Joints count from 0. `mark_deg` is the
  /// motor's angle behind its gear in the new cell's home pose.
  virtual std::string new_keys(std::size_t /*joint*/, double /*mark_deg*/) const { return ""; }

  /// Reads the keys that only this kind has from an item of `drives` into the settings of a joint.
  /// Joints count from 0. Faults go to the document.
  virtual void read(Fields& /*drive*/, CellSettings& /*cell*/, std::size_t /*joint*/) const {}

  /// Fills in what follows from other settings. It is called once the whole file is free of faults.
  virtual void complete(CellSettings& /*cell*/, std::size_t /*joint*/) const {}

  /// Returns whether the motors of a move take the same time, so that their angles change in one
  /// straight line; else each goes as fast as it may.
  virtual bool moves_straight() const { return true; }

  /// Opens a cell's drives, unless they are virtual. Throws DriveError when one cannot be used.
  virtual std::shared_ptr<DriveGroup> open(const CellSettings& /*cell*/) const { return nullptr; }
};

/// One kind of tracker, with its own keys of a cell file's `tracker` block.
class TrackerKind : public DeviceKind {
 public:
  /// Returns false when what this kind opens never gives a reading.
  virtual bool measures() const { return true; }

  /// Returns whether a person takes the readings, who reads each monument only once.
  virtual bool by_hand() const { return false; }

  /// Reads the keys that only this kind has. Faults go to the document.
  virtual std::shared_ptr<const DeviceDetails> read(Fields& /*tracker*/) const { return nullptr; }

  /// Opens a cell's tracker, unless it is virtual. Throws WorkError when it cannot be heard at all.
  virtual std::shared_ptr<Tracker> open(const CellSettings& /*cell*/) const { return nullptr; }
};

/// Lists the kinds of devices that a cell file may name.
struct DeviceKinds {
  std::vector<const CameraKind*> cameras;
  std::vector<const DriveKind*> drives;
  std::vector<const TrackerKind*> trackers;
};

}  // namespace planar
