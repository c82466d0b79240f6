#include "planar_servo/console/certificate_job.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "planar_servo/base/io/terminal.h"
#include "planar_servo/certificate/certificate_report.h"

namespace planar {
namespace {

/// Returns how a certificate ended, in words.
std::string words_of(const Certificate& certificate) {
  if (!certificate.run.ended_by.empty())
    return fmt::format(
        "{}; the cell is in doubt and no further move was made: mend it, then begin the same "
        "certificate again to continue",
        certificate.run.ended_by);
  const CellAccuracy& accuracy = certificate.accuracy;
  std::string words = fmt::format("{} of {} moves reached and judged by the {}", accuracy.judged,
                                  accuracy.moves, name_in(kJudgeKinds, certificate.run.judge));
  for (const auto& [name, figure] : worst_pose_figures(accuracy))
    words += fmt::format("; {} {}", name, figure);
  return words;
}

void require_size(const CertificateSize& size) {
  const auto require = [](const char* what, int count, int least, int most) {
    if (count < least || count > most)
      throw InputError(
          {fmt::format("is {}", count), fmt::format("take {} to {}", least, most), what});
  };
  require("cycles", size.cycles, CertificateSize::kLeastCycles, CertificateSize::kMostCycles);
  require("targets", size.targets, 1, CertificateSize::kMostTargets);
}

}  // namespace

int CertificateJob::begin(const std::string& name, const CertificateSize& size, StopsKnown known) {
  require_size(size);
  const std::filesystem::path out = jobs_.folder(name);
  const auto work = [=](CellDevices& devices, const CellJobs::Stop& stop,
                        const CellJobs::Begun& begun) {
    CertificateRequest request{jobs_.request(stop), size, jobs_.watch()};
    request.servo.out = out;
    return certify(request, devices, begun);
  };
  return jobs_.begin(Doing::kRunning, "certificate", name, known, work);
}

CellJobs::Ending CertificateJob::certify(const CertificateRequest& request, CellDevices& devices,
                                         const CellJobs::Begun& begun) {
  const auto at_page = std::make_shared<PageOperator>(board_, request.servo.stop, [] {});
  const auto seated = seat_.take(at_page);
  devices.tracker().ask_of(at_page);
  const std::shared_ptr<void> given_back(
      nullptr, [&](void*) { devices.tracker().ask_of(std::make_shared<Terminal>()); });
  const auto lend = [&](const CellSettings& /*cell*/) {
    return std::shared_ptr<CellDevices>(std::shared_ptr<void>(), &devices);
  };
  bool is_begun = false;
  const Certificate certificate =
      certificate_of(run_certificate(request, lend, [&](std::size_t done, std::size_t all) {
        if (!std::exchange(is_begun, true)) return begun(done, all);
        jobs_.show_progress(done, all);
      }));
  if (!is_begun) begun(certificate.run.moves.size(), certificate.run.moves.size());
  write_certificate(certificate);
  const std::string words = words_of(certificate);
  jobs_.hold(certificate.run.ended_by.empty() ? "" : words);
  return {words, certificate.all_count()};
}

}  // namespace planar
