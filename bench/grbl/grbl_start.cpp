#include "grbl_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/hardware/drives/grbl_drives.h"
#include "support/grbl_bench.h"

namespace planar {

void print_start_time(int repeats) {
  test::GrblBench bench;
  GrblDrives drives(bench.settings);
  drives.energize();
  const SteadyClock clock;
  std::vector<double> times_ms;
  for (int i = 0; i < 20 * repeats; ++i) {
    const auto before = bench.board.shafts();
    const double start_s = clock.now_s();
    drives.set_targets({i % 2 == 0 ? 100 : 0, 0, 0});
    while (bench.board.shafts() == before)
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    times_ms.push_back(1e3 * (clock.now_s() - start_s));
    while (drives.status()[0].moving) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::sort(times_ms.begin(), times_ms.end());
  fmt::print("from command to the first pulse: median {:.1f} ms\n", times_ms[times_ms.size() / 2]);
}

}  // namespace planar
