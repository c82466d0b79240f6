#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/certificate/test_places.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/machine/judge/cell_judge.h"
#include "planar_servo/work/run/servo_run.h"

namespace planar {

/// Says which cell is certified, and where the files go.
struct CertificateRequest {
  ServoRequest servo;  ///< `resume` is not used: the same request continues with what there is
  CertificateSize size;
  ServoRun::Observer watch{};  ///< is called at every look; may be empty
};

struct CertificateRun {
  CertificateRequest request;
  VisionCalibration vision;
  TestPlaces places{};
  JudgeKind judge{JudgeKind::kTruth};
  std::vector<JudgedMove> moves{};
  std::vector<std::string> accepted{};  ///< objections to the cell's files
  std::string ended_by{};               ///< why no further move was made; empty when complete
};

/// Opens a cell's devices, or lends those that are open, by a pointer that owns nothing.
using OpenDevices = std::function<std::shared_ptr<CellDevices>(const CellSettings&)>;

/// Moves a cell through certificate_moves() and has the end of each judged. Each judged move is
/// appended to cycles.csv in servo.out at once, beside steps.csv and results.csv of all moves; the
/// same request continues where they end. Throws InputError before anything moves when nobody can
/// judge the cell, when find_test_places() fails, and when the folder holds something else or a
/// certificate that was begun with other files, sizes or settings. Throws what ServoRun throws.
/// `progress`, which may be empty, is told of the moves that are there before the first one is
/// made, and of each.
CertificateRun run_certificate(
    const CertificateRequest& request, const OpenDevices& open,
    const std::function<void(std::size_t done, std::size_t all)>& progress = {});

}  // namespace planar
