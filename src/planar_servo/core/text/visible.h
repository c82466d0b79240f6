#pragma once

#include <string>
#include <string_view>

namespace planar {

/// Returns the text for a terminal: every control character but the line end and the tabulator is
/// written as `\x1b`, so that what stands in a file or comes from a port controls no terminal.
std::string visible(std::string_view text);

}  // namespace planar
