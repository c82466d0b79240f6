#include "planar_servo/console/http/api_description.h"

#include <utility>

namespace planar {
namespace {

using ApiJson = nlohmann::ordered_json;

ApiJson reference(const char* kind, const std::string& name) {
  return {{"$ref", std::string("#/components/") + kind + "/" + name}};
}

/// Returns a schema, which the list names or writes out.
ApiJson schema_of(const ApiJson& listed) {
  return listed.is_string() ? reference("schemas", listed) : listed;
}

ApiJson body_of(const ApiJson& listed) {
  ApiJson properties = ApiJson::object();
  const ApiJson taken = listed.value("body", ApiJson::object());
  for (const auto& [key, schema] : taken.items()) properties[key] = schema_of(schema);
  const ApiJson schema{{"type", "object"},
                       {"additionalProperties", false},
                       {"required", listed.value("required", ApiJson::array())},
                       {"properties", properties}};
  return {{"required", true}, {"content", {{"application/json", {{"schema", schema}}}}}};
}

ApiJson responses_of(const ApiJson& listed) {
  const std::string type = listed.value("type", "application/json");
  ApiJson content = ApiJson::object();
  if (type == "application/json")
    content["schema"] = schema_of(listed.value("answer", ApiJson{{"type", "object"}}));
  ApiJson responses{{"200", {{"description", "the answer"}, {"content", {{type, content}}}}}};
  if (listed.value("may_be_empty", false))
    responses["204"] = {{"description", "there is none yet"}};
  responses["default"] = reference("responses", "Refused");
  return responses;
}

ApiJson operation_of(const std::string& method, const ApiJson& listed) {
  ApiJson operation{{"summary", listed.at("summary")}};
  if (method == "post") {
    operation["parameters"] = {reference("parameters", "Client"), reference("parameters", "Stops")};
    operation["requestBody"] = body_of(listed);
  } else if (listed.contains("parameters")) {
    operation["parameters"] = listed.at("parameters");
  }
  operation["responses"] = responses_of(listed);
  return operation;
}

}  // namespace

ApiDescription::ApiDescription(std::string_view list) {
  ApiJson document = ApiJson::parse(list);
  ApiJson paths = ApiJson::object();
  for (const auto& [request, listed] : document.at("requests").items()) {
    const std::size_t space = request.find(' ');
    const std::string method = request.substr(0, space) == "POST" ? "post" : "get";
    const std::string path = request.substr(space + 1);
    paths[path][method] = operation_of(method, listed);
    if (method != "post") continue;
    std::vector<std::string>& keys = keys_[path];
    const ApiJson taken = listed.value("body", ApiJson::object());
    for (const auto& entry : taken.items()) keys.push_back(entry.key());
  }
  document.erase("requests");
  document["paths"] = std::move(paths);
  openapi_ = document.dump(1);
}

}  // namespace planar
