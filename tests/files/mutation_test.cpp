#include <catch2/catch.hpp>
#include <functional>
#include <random>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

constexpr int kMutations = 1500;

/// The text with a few bytes replaced, removed or doubled.
std::string mutated(std::string text, std::mt19937& random) {
  const int changes = 1 + static_cast<int>(random() % 4);
  for (int i = 0; i < changes && !text.empty(); ++i) {
    const std::size_t at = random() % text.size();
    switch (random() % 3) {
      case 0:
        text[at] = static_cast<char>(random() % 256);
        break;
      case 1:
        text.erase(at, 1 + random() % 8);
        break;
      default:
        text.insert(at, text.substr(at, 1 + random() % 8));
    }
  }
  return text;
}

/// Every mutation is either read or refused with InputError.
void check_mutations(const std::string& text,
                     const std::function<void(const std::filesystem::path&)>& read) {
  const test::TemporaryFolder folder;
  std::mt19937 random(20261121);
  int refused = 0;
  for (int i = 0; i < kMutations; ++i) {
    const auto path = folder.write("frames.csv", mutated(text, random));
    try {
      read(path);
    } catch (const InputError& e) {
      ++refused;
      REQUIRE(std::string(e.what()).find("frames.csv") != std::string::npos);
    }
  }
  CHECK(refused > kMutations / 10);
}

TEST_CASE("A damaged cell file is read or refused by name, never worse") {
  check_mutations(read_file(test::paper_cell_file()), [](const auto& path) { read_cell(path); });
}

TEST_CASE("A damaged table is read or refused by name, never worse") {
  const std::string pairs =
      "# format: planar-servo/pairs/1\nid,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm\n"
      "a,1.0,2.0,1.1,2.1\nb,-3.5e1,4,-35.1,4.2\n";
  check_mutations(pairs, [](const auto& path) { read_pairs(path); });
  const std::string plan = "id,plan,x_mm,y_mm\na,train,1,2\ng,grid,,\n";
  check_mutations(plan, [](const auto& path) { read_plan(path, 0.0); });
  const std::string frames = frames_header() + frame_line({"t1",
                                                           "images/t1.pgm",
                                                           1.5,
                                                           Purpose::kTrain,
                                                           {0.1, -0.2, 0.3},
                                                           {10, -20, 30},
                                                           {1, 2, 3, 4}});
  check_mutations(frames, [](const auto& path) { read_frames(path.parent_path()); });
  const std::string lamps = "id,status,u1_px,v1_px,u2_px,v2_px\nt1,ok,1,2,3,4\nt2,no_lamp,,,,\n";
  check_mutations(lamps, [](const auto& path) { read_lamps(path); });
  const std::string targets = targets_header() + target_line({"a", {0.1, 0.2}, 0.3});
  check_mutations(targets, [](const auto& path) { read_targets(path); });
  const std::string tracker = "Name;t;X;Y;Z\na;0,5;1,5;2;3\nb;1;-1,5e1;2;3\n";
  const TrackerDialect dialect{
      {';', true, {{"id", "Name"}, {"t_s", "t"}, {"x_mm", "X"}, {"y_mm", "Y"}, {"z_mm", "Z"}}}};
  check_mutations(tracker, [&](const auto& path) { read_tracker(path, dialect); });
}

}  // namespace
}  // namespace planar
