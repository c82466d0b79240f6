// Measures lamps by our methods and by other people's, in turn in one run: centres in a window of
// 128 x 128 pixels beside the Cramer-Rao bound, and detection in full frames beside one read of the
// frame.
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "lamps/center_table.h"
#include "lamps/detection_table.h"
#include "lamps/unseen_defects.h"

int main(int argc, char** argv) {
  using namespace planar::bench;
  CLI::App app{"Measures and finds lamps by our and by other methods; errors, times, misses"};
  int positions = 400, frames = 1000;
  unsigned seed = 1;
  bool unseen = false;
  std::string json_file;
  app.add_option("--positions", positions, "lamps per family; 0: no centres")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--frames", frames, "full frames per kind of clutter; 0: no detection")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--unseen", unseen, "only the families of defects that were kept unseen");
  app.add_option("--seed", seed, "of the random numbers");
  app.add_option("--json", json_file, "file for the results");
  CLI11_PARSE(app, argc, argv);

  cv::setNumThreads(1);
  nlohmann::json json{{"positions", positions}, {"frames", frames}, {"seed", seed}};
  if (positions > 0) {
    json["families"] =
        measure_centers(unseen ? unseen_families() : lamp_families(), positions, seed);
  }
  if (frames > 0 && !unseen) json["detection"] = measure_detection(frames, seed);
  if (!json_file.empty()) {
    std::ofstream out(json_file);
    out << json.dump(2) << "\n";
    if (!out) {
      std::cerr << "cannot write " << json_file << "\n";
      return 1;
    }
  }
  return 0;
}
