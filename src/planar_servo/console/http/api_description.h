#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// The OpenAPI document of a console, written out from a shorter form. A schema there is the name
/// of one of the document's or of a type of JSON, with [] for an array of it and |null where it may
/// be null, or an object with such a `type`; of `properties` all are there but those with a ?.
class ApiDescription {
 public:
  /// `frame` is the document without its requests.
  explicit ApiDescription(std::string_view frame);

  /// Adds a request, such as "GET /api/lamp/{n}.jpg", with schemas, as JSON, for what is asked by
  /// its `path` and `query` or in its `body`, and for its `answer`; or with another `type` of
  /// content, which `may_be_empty`. Returns the keys of the body.
  std::vector<std::string> add(const std::string& request, const std::string& summary,
                               std::string_view schemas);

  std::string text() const { return document_.dump(1); }

 private:
  nlohmann::ordered_json document_;
};

}  // namespace planar
