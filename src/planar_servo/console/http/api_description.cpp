#include "planar_servo/console/http/api_description.h"

#include <cctype>
#include <utility>

#include "planar_servo/console/json_values.h"

namespace planar {
namespace {

using ApiJson = nlohmann::ordered_json;

/// Takes an ending off a text. Returns whether it was there.
bool take_off(std::string& text, std::string_view ending) {
  const bool is_there = text.size() > ending.size() &&
                        text.compare(text.size() - ending.size(), ending.npos, ending) == 0;
  if (is_there) text.resize(text.size() - ending.size());
  return is_there;
}

ApiJson reference(const char* kind, const std::string& name) {
  return {{"$ref", std::string("#/components/") + kind + "/" + name}};
}

ApiJson schema_named(std::string name) {
  if (take_off(name, "|null")) {
    ApiJson schema = schema_named(name);
    if (!schema.contains("type")) return {{"oneOf", {schema, {{"type", "null"}}}}};
    schema["type"] = {schema["type"], "null"};
    return schema;
  }
  if (take_off(name, "[]")) return {{"type", "array"}, {"items", schema_named(name)}};
  if (std::isupper(static_cast<unsigned char>(name.front())) != 0)
    return reference("schemas", name);
  return {{"type", name}};
}

ApiJson schema_of(const ApiJson& listed) {
  if (listed.is_string()) return schema_named(listed);
  ApiJson schema = listed;
  if (const auto type = schema.find("type"); type != schema.end()) {
    const ApiJson named = schema_named(*type);
    schema.erase("type");
    schema.update(named);
  }
  if (listed.contains("items")) schema["items"] = schema_of(listed["items"]);
  if (!listed.contains("properties")) return schema;
  if (!listed.contains("type")) schema["type"] = "object";
  schema["required"] = ApiJson::array();
  schema["properties"] = ApiJson::object();
  for (const auto& [key, property] : listed["properties"].items()) {
    std::string name = key;
    if (!take_off(name, "?")) schema["required"].push_back(name);
    schema["properties"][name] = schema_of(property);
  }
  return schema;
}

ApiJson parameters_of(const ApiJson& listed) {
  ApiJson parameters = ApiJson::array();
  for (const char* where : {"path", "query"}) {
    const ApiJson asked = listed.value(where, ApiJson::object());
    for (const auto& [key, parameter] : asked.items()) {
      std::string name = key;
      const bool required = !take_off(name, "?");
      parameters.push_back({{"name", name},
                            {"in", where},
                            {"required", required},
                            {"schema", schema_of(parameter)}});
    }
  }
  return parameters;
}

ApiJson responses_of(const ApiJson& listed) {
  const std::string type = listed.value("type", "application/json");
  ApiJson content = ApiJson::object();
  if (type == "application/json")
    content["schema"] = schema_of(listed.value("answer", ApiJson("object")));
  ApiJson responses{{"200", {{"description", "the answer"}, {"content", {{type, content}}}}}};
  if (listed.value("may_be_empty", false))
    responses["204"] = {{"description", "there is none yet"}};
  responses["default"] = reference("responses", "Refused");
  return responses;
}

}  // namespace

ApiDescription::ApiDescription(std::string_view frame) : document_(ApiJson::parse(frame)) {
  for (ApiJson& schema : document_.at("components").at("schemas")) schema = schema_of(schema);
  document_["paths"] = ApiJson::object();
}

std::vector<std::string> ApiDescription::add(const std::string& request, const std::string& summary,
                                             std::string_view schemas) {
  const ApiJson listed = ApiJson::parse(schemas);
  const std::size_t space = request.find(' ');
  const bool is_post = request.substr(0, space) == "POST";
  ApiJson& operation = document_["paths"][request.substr(space + 1)][is_post ? "post" : "get"];
  operation["summary"] = summary;
  operation["responses"] = responses_of(listed);
  if (!is_post) {
    if (ApiJson parameters = parameters_of(listed); !parameters.empty())
      operation["parameters"] = std::move(parameters);
    return {};
  }
  ApiJson body = schema_of(
      {{"additionalProperties", false}, {"properties", listed.value("body", ApiJson::object())}});
  operation["parameters"] = {reference("parameters", "Client"), reference("parameters", "Stops")};
  std::vector<std::string> keys;
  for (const auto& property : body["properties"].items()) keys.push_back(property.key());
  operation["requestBody"] = {{"required", true},
                              {"content", {{"application/json", {{"schema", std::move(body)}}}}}};
  return keys;
}

}  // namespace planar
