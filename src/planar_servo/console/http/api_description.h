#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// The requests that the console answers, as page/openapi.json lists them: each once, with what it
/// takes and answers. Programs read it written out as OpenAPI.
class ApiDescription {
 public:
  /// `list` is the text of that file.
  explicit ApiDescription(std::string_view list);

  /// Returns the keys that the body of a POST to this path may have. Throws std::out_of_range for a
  /// path that is not listed.
  const std::vector<std::string>& keys(const std::string& path) const { return keys_.at(path); }
  /// Returns the description as an OpenAPI document.
  const std::string& openapi() const { return openapi_; }

 private:
  std::map<std::string, std::vector<std::string>> keys_;
  std::string openapi_;
};

}  // namespace planar
