#include "support/sample_cells.h"

namespace planar::test {

std::filesystem::path paper_cell_file() {
  return std::filesystem::path(PLANAR_CALIB) / "paper" / "cell.yaml";
}

std::filesystem::path workshop_cell_file() {
  return std::filesystem::path(PLANAR_CALIB) / "workshop" / "cell.yaml";
}

}  // namespace planar::test
