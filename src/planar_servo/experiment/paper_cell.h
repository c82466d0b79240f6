#pragma once

namespace planar {

/// Returns the text that calib/paper/cell.yaml had when the program was built.
const char* paper_cell_text();

}  // namespace planar
