#include "planar_servo/console/http/console_api.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

constexpr char kList[] = R"({
  "openapi": "3.1.0",
  "requests": {
    "GET /api/lamp/{n}.jpg": {"summary": "a lamp", "parameters": [{"name": "n", "in": "path"}], "type": "image/jpeg", "may_be_empty": true},
    "GET /api/jobs": {"summary": "all", "answer": {"type": "array", "items": "Job"}},
    "POST /api/jobs": {"summary": "begins one", "optional": ["size"], "body": {"out": "Name", "size": {"type": "integer"}}, "answer": "Job"},
    "POST /api/end": {"summary": "ends it"}
  },
  "components": {"schemas": {"Job": {"optional": ["ended"], "properties": {"name": "Name", "ended": {"oneOf": ["Name", {"type": "null"}]}}}}}
})";

TEST_CASE("A request that is listed once is checked by its keys and described in OpenAPI") {
  const ApiDescription description(kList);
  CHECK(description.keys("/api/jobs") == std::vector<std::string>{"out", "size"});
  CHECK(description.keys("/api/end").empty());
  CHECK_THROWS_AS(description.keys("/api/other"), std::out_of_range);
  const auto document = nlohmann::json::parse(description.openapi());
  CHECK_FALSE(document.contains("requests"));
  const auto& begins = document["paths"]["/api/jobs"]["post"];
  const auto& body = begins["requestBody"]["content"]["application/json"]["schema"];
  CHECK(body["required"] == nlohmann::json{"out"});
  CHECK(body["additionalProperties"] == false);
  CHECK(body["properties"]["out"]["$ref"] == "#/components/schemas/Name");
  CHECK(begins["responses"]["200"]["content"]["application/json"]["schema"]["$ref"] ==
        "#/components/schemas/Job");
  CHECK(begins["responses"]["default"]["$ref"] == "#/components/responses/Refused");
  CHECK(document["paths"]["/api/jobs"]["get"]["responses"]["200"]["content"]["application/json"]
                ["schema"]["type"] == "array");
  CHECK(document["paths"]["/api/jobs"]["get"]["responses"]["200"]["content"]["application/json"]
                ["schema"]["items"]["$ref"] == "#/components/schemas/Job");
  const auto& job = document["components"]["schemas"]["Job"];
  CHECK(job["type"] == "object");
  CHECK(job["required"] == nlohmann::json{"name"});
  CHECK_FALSE(job.contains("optional"));
  CHECK(job["properties"]["name"]["$ref"] == "#/components/schemas/Name");
  CHECK(job["properties"]["ended"]["oneOf"][0]["$ref"] == "#/components/schemas/Name");
  const auto& lamp = document["paths"]["/api/lamp/{n}.jpg"]["get"];
  CHECK(lamp["responses"].contains("204"));
  CHECK(lamp["responses"]["200"]["content"].contains("image/jpeg"));
  CHECK(lamp["parameters"][0]["name"] == "n");
}

}  // namespace
}  // namespace planar
