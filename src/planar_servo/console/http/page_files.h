#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// A file of the page that is built into the program.
struct PageFile {
  std::string path;  ///< as browsers ask for it, such as "/page.js"
  const char* type;  ///< MIME type
  std::string_view text;
};

const std::vector<PageFile>& page_files();

}  // namespace planar
