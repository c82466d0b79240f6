#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/learn/field/arm/arm_model.h"
#include "planar_servo/learn/field/fit_lamp_field.h"
#include "planar_servo/learn/field/lay_information.h"
#include "planar_servo/loop/vision/see_tool.h"

namespace planar {

/// Returns the arm, the camera's place and the tool as the cell and its calibration have them.
ArmNominal nominal_arm(const CellSettings& cell, const VisionCalibration& vision);

/// Widens the registration of the arm's tracker as readings scatter more than at the tracker
/// itself: the monuments are read from about as far as the samples' places.
void spread_registration(ArmNominal& nominal, const CellSettings& cell,
                         const std::vector<PoseSample>& samples);

/// Returns the poses of pairs.csv from which field and arm are learned: those of plan train or of
/// none, the sweeps, and the unattended ones. Places of other plans are kept for checks. Times are
/// counted from the last of all pairs. Throws InputError naming a pair without lamps, joints or
/// standard deviations.
std::vector<PoseSample> pose_samples(const CellSettings& cell, const std::vector<PairRow>& pairs);

/// Returns the lays of lays.csv. Throws InputError for a dot without a standard deviation, and for
/// lays of which only some have a known pitch.
LaidDots laid_dots(const std::vector<LayRow>& rows);

/// The inputs of a field at the lamps, and the files for it and the arm found with it.
struct LampFieldFiles {
  std::filesystem::path pairs;
  std::filesystem::path lays{};  ///< empty where there are none
  std::filesystem::path map{};
  std::filesystem::path arm{};  ///< empty where nobody wants it
  /// Marks of a bar of certified length, and of the base at their places in its frame, each as
  /// work.csv has them; empty where there are none.
  std::filesystem::path bar{}, marks{};
  double bar_sigma{0.0}, marks_sigma{0.0};  ///< of the length, and of a place per axis, metres
  /// Each reads the frames of a whole picture that shows some of them. Passed in, so that what
  /// learns from tables alone loads no decoders of pictures.
  std::vector<std::function<std::vector<Frame>()>> pictures{};

  std::vector<MadeFile> inputs() const;
};

/// Returns the lays, and the bar and the marks as the pictures show them. Of these two what lies
/// beyond the radius tells nothing; it is left out, and named in the log. Throws InputError where
/// nothing of one is left.
LaidDots laid_things(const LampFieldFiles& files, const VisionCalibration& vision, double radius);

/// Learns the field of a cell whose camera, workplane and tool are `vision`. Throws what reading
/// the tables and the pictures and fit_lamp_field() throw.
LampFieldFit learn_lamp_field(const LampFieldFiles& files, const CellSettings& cell,
                              const VisionCalibration& vision, const Progress& progress = {});

void write_lamp_field(const LampFieldFiles& files, const LampFieldFit& fit,
                      const CellSettings& cell, const std::string& program);

}  // namespace planar
