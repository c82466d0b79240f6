#include "planar_servo/doctor/doctor_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "planar_servo/core/names.h"

namespace planar {
namespace {

constexpr Named<Finding::Verdict> kVerdicts[] = {{Finding::Verdict::kWell, "well"},
                                                 {Finding::Verdict::kDoubtful, "doubtful"},
                                                 {Finding::Verdict::kFaulty, "faulty"}};

}  // namespace

bool is_sound(const std::vector<Finding>& findings) {
  return std::none_of(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.verdict == Finding::Verdict::kFaulty;
  });
}

std::string findings_text(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& finding : findings) {
    text += fmt::format("{:9} {}: {}\n", name_in(kVerdicts, finding.verdict), finding.subject,
                        finding.what);
    if (!finding.remedy.empty()) text += fmt::format("          -> {}\n", finding.remedy);
  }
  return text;
}

nlohmann::json findings_json(const std::vector<Finding>& findings) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Finding& finding : findings)
    rows.push_back({{"verdict", name_in(kVerdicts, finding.verdict)},
                    {"subject", finding.subject},
                    {"what", finding.what},
                    {"remedy", finding.remedy}});
  return {{"findings", rows}};
}

}  // namespace planar
