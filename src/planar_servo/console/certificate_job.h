#pragma once

#include <string>

#include "planar_servo/certificate/certify.h"
#include "planar_servo/console/cell_jobs.h"
#include "planar_servo/console/page_operator.h"

namespace planar {

/// Certifies a cell as planar-certify does, with the person at a page beside the tracker.
class CertificateJob {
 public:
  /// All must outlive it.
  CertificateJob(StateBoard& board, CellJobs& jobs, PageSeat& seat)
      : board_(board), jobs_(jobs), seat_(seat) {}

  /// Begins a certificate in the folder `name` beside the cell file, or continues the one that was
  /// broken off there, and returns the number of its job once its files are read. Throws as the
  /// functions of CellJobs do, and InputError for sizes that planar-certify refuses.
  int begin(const std::string& name, const CertificateSize& size, StopsKnown known);

 private:
  CellJobs::Ending certify(const CertificateRequest& request, CellDevices& devices,
                           const CellJobs::Begun& begun);

  StateBoard& board_;
  CellJobs& jobs_;
  PageSeat& seat_;
};

}  // namespace planar
