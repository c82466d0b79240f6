#pragma once

namespace planar {

/// calib/paper/cell.yaml as it was when the program was built.
const char* paper_cell_text();

}  // namespace planar
