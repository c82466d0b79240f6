#include "support/sample_cells.h"

namespace planar::test {

std::filesystem::path paper_cell_file() {
  return std::filesystem::path(PLANAR_CALIB) / "paper" / "cell.yaml";
}

}  // namespace planar::test
