#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/cell/finding.h"

namespace planar {

class DriveGroup;
class FrameSource;
class Tracker;
class VirtualCell;
class YamlNode;
struct CellSettings;

/// Settings that only one kind of device has. Each kind derives its own and alone reads them.
struct DeviceDetails {
  virtual ~DeviceDetails() = default;
};

/// What all kinds of devices have in common: the name by which a cell file asks for the kind.
class DeviceKind {
 public:
  virtual ~DeviceKind() = default;

  /// The word in the cell file.
  virtual std::string name() const = 0;

  /// True of devices that exist only in a virtual cell. Virtual and real devices do not mix.
  virtual bool is_virtual() const { return false; }
};

/// One kind of camera: reads its own keys of a cell file's `camera` block, opens the camera and
/// examines it for the doctor.
class CameraKind : public DeviceKind {
 public:
  /// Why no camera of this kind can be opened, with what to do instead; empty where one can.
  virtual std::string refusal() const { return ""; }

  /// Reads the keys that only this kind has; faults go to the node's document.
  virtual std::shared_ptr<const DeviceDetails> read(const YamlNode& /*camera*/) const {
    return nullptr;
  }

  /// Opens the camera of a cell whose camera is of this kind. `world` is the cell's virtual world
  /// for a virtual kind and null for the others. Throws WorkError when the camera does not answer,
  /// InputError for settings that it cannot have.
  virtual std::shared_ptr<FrameSource> open(const CellSettings& cell,
                                            const std::shared_ptr<VirtualCell>& world) const = 0;

  /// What is well and what is not with the camera, found without moving anything.
  virtual std::vector<Finding> examine(const CellSettings& cell) const = 0;
};

/// One kind of drive. The three joints of a cell have drives of one kind.
class DriveKind : public DeviceKind {
 public:
  /// Reads the keys that only this kind has from an item of `drives` into the settings of that
  /// joint, which counts from 0; faults go to the node's document.
  virtual void read(const YamlNode& /*drive*/, CellSettings& /*cell*/,
                    std::size_t /*joint*/) const {}

  /// Fills in what follows from other settings, once the whole file was found free of faults.
  virtual void complete(CellSettings& /*cell*/, std::size_t /*joint*/) const {}

  /// Opens the drives of a cell whose drives are of this kind; `world` is as in CameraKind::open().
  /// Throws DriveError when a drive cannot be used.
  virtual std::shared_ptr<DriveGroup> open(const CellSettings& cell,
                                           const std::shared_ptr<VirtualCell>& world) const = 0;

  /// What is well and what is not with the drives, found without moving or switching on anything.
  virtual std::vector<Finding> examine(const CellSettings& cell) const = 0;
};

/// One kind of tracker.
class TrackerKind : public DeviceKind {
 public:
  /// Opens the tracker; `world` is as in CameraKind::open().
  virtual std::shared_ptr<Tracker> open(const CellSettings& cell,
                                        const std::shared_ptr<VirtualCell>& world) const = 0;
};

/// The kinds of devices that a cell file may ask for.
struct DeviceKinds {
  std::vector<const CameraKind*> cameras;
  std::vector<const DriveKind*> drives;
  std::vector<const TrackerKind*> trackers;
};

}  // namespace planar
