#pragma once

#include <string>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/tracker_lines.h"

namespace planar {

class Fields;

/// The keys of a tracker whose program writes lines.
struct StreamDetails final : DeviceDetails {
  std::string source;  ///< a file's name as the cell file has it, or an address HOST:PORT
  TrackerDialect dialect;
};

/// Reads the optional keys `separator`, `decimal_comma` and `unit`.
void read_number_keys(Fields& tracker, TrackerDialect& dialect);

/// Reads the keys of read_number_keys() and the optional map `columns`.
void read_dialect(Fields& tracker, TrackerDialect& dialect);

const StreamDetails& stream_details(const CellSettings& cell);

}  // namespace planar
