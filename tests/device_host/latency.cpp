#include "device_host/latency.h"

#include <algorithm>
#include <string>

#include "planar_servo/base/io/csv_table.h"

namespace planar::test {

std::vector<double> exposure_to_command_s(const std::filesystem::path& run,
                                          const std::vector<double>& commands_s) {
  CsvFile steps(run / "steps.csv", "steps", {"target", "t_s"});
  std::vector<double> delays_s;
  std::string target;
  double exposed_s = 0.0;
  while (steps.next_row()) {
    if (steps.text("target") == target) {  // the step before was corrected
      const auto command = std::upper_bound(commands_s.begin(), commands_s.end(), exposed_s);
      if (command != commands_s.end()) delays_s.push_back(*command - exposed_s);
    }
    target = steps.text("target");
    exposed_s = steps.number("t_s");
  }
  steps.throw_if_faulty_or_empty();
  return delays_s;
}

}  // namespace planar::test
