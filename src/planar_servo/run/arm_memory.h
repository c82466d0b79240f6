#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/vision/found_landings.h"

namespace planar {

/// Returns what is known so far of a planner's arm, from the cell's arm_learned file unless there
/// is none, it is to be forgotten, or it belongs to another arm or map, which is logged. Throws
/// InputError for a file with faults.
LearnedArm remembered_arm(const CellSettings& cell, const JointPlanner& planner, bool forgets);

/// Keeps what a run learns of its arm in the cell's arm_learned file, where it names one: every ten
/// minutes and at the end.
class ArmMemory {
 public:
  /// Takes the landings, which must outlive it. The file is made from what the cell names now.
  ArmMemory(const CellSettings& cell, const LearningLandings& landings);
  /// Keeps the last lessons. A file that cannot be written is only logged.
  ~ArmMemory();
  ArmMemory(const ArmMemory&) = delete;
  ArmMemory& operator=(const ArmMemory&) = delete;

  /// Throws WorkError when the file cannot be written.
  void keep_if_due(double now_s);

 private:
  void keep();

  std::filesystem::path file_;
  std::vector<Origin> origins_;
  const LearningLandings& landings_;
  int kept_lessons_{0};
  std::optional<double> kept_s_;
};

}  // namespace planar
