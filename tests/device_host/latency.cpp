#include "device_host/latency.h"

#include <algorithm>

#include "text/csv_table.h"

namespace planar::test {

std::vector<double> exposure_to_command_s(const std::filesystem::path& run,
                                          const std::vector<double>& commands_s) {
  CsvTable steps = CsvTable::read(run / "steps.csv", "steps", {"target", "t_s"});
  std::vector<double> delays_s;
  for (std::size_t row = 0; row + 1 < steps.size(); ++row) {
    if (steps.text(row, "target") != steps.text(row + 1, "target")) continue;  // nothing corrected
    const double exposed_s = steps.number(row, "t_s");
    const auto command = std::upper_bound(commands_s.begin(), commands_s.end(), exposed_s);
    if (command != commands_s.end()) delays_s.push_back(*command - exposed_s);
  }
  steps.throw_if_faulty_or_empty();
  return delays_s;
}

}  // namespace planar::test
