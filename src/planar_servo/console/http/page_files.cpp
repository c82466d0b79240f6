#include "planar_servo/console/http/page_files.h"

#include "console_page.h"

namespace planar {
namespace {

bool ends(std::string_view text, std::string_view with) {
  return text.size() >= with.size() && text.substr(text.size() - with.size()) == with;
}

const char* type_of(std::string_view name) {
  if (ends(name, ".js")) return "text/javascript; charset=utf-8";
  if (ends(name, ".css")) return "text/css; charset=utf-8";
  if (ends(name, ".json")) return "application/json";
  if (ends(name, ".svg")) return "image/svg+xml";
  return "text/html; charset=utf-8";
}

}  // namespace

const std::vector<PageFile>& page_files() {
  static const std::vector<PageFile> files = [] {
    std::vector<PageFile> all;
    for (const auto& [name, text] : kConsolePage) {
      const bool is_index = std::string_view(name) == "index.html";
      all.push_back({std::string("/") + (is_index ? "" : name), type_of(name), text});
    }
    return all;
  }();
  return files;
}

}  // namespace planar
