#include "planar_servo/console/http/api_description.h"

#include <catch2/catch.hpp>
#include <set>

#include "planar_servo/console/http/requests.h"

namespace planar {
namespace {

using Keys = std::vector<std::string>;

constexpr char kFrame[] = R"({
  "openapi": "3.1.0",
  "components": {"schemas": {
    "Job": {"properties": {"name": "Name", "ended?": "Name|null",
                           "left_s": {"type": "number|null", "description": "to go"}}},
    "All": {"type": "object|null",
            "properties": {"jobs": "Job[]|null",
                           "rows": {"type": "array", "items": {"properties": {}}}}}
  }}
})";

TEST_CASE("A request that is listed once is checked by its keys and described in OpenAPI") {
  ApiDescription description(kFrame);
  const Keys of_lamp = description.add("GET /api/lamp/{n}.jpg", "a lamp", R"({
    "path": {"n": {"enum": [1, 2]}}, "query": {"size?": "integer"},
    "type": "image/jpeg", "may_be_empty": true})");
  const Keys of_jobs = description.add("GET /api/jobs", "all", R"({"answer": "Job[]"})");
  const Keys of_job = description.add("POST /api/jobs", "begins one", R"({
    "body": {"out": "Name", "size?": "integer"}, "answer": "Job"})");
  CHECK(of_lamp.empty());
  CHECK(of_jobs.empty());
  CHECK(of_job == Keys{"out", "size"});
  CHECK(description.add("POST /api/end", "ends it", "{}").empty());
  const auto document = nlohmann::json::parse(description.text());
  const auto& begins = document["paths"]["/api/jobs"]["post"];
  const auto& body = begins["requestBody"]["content"]["application/json"]["schema"];
  CHECK(begins["summary"] == "begins one");
  CHECK(body["required"] == nlohmann::json{"out"});
  CHECK(body["additionalProperties"] == false);
  CHECK(body["properties"]["out"]["$ref"] == "#/components/schemas/Name");
  CHECK(body["properties"]["size"]["type"] == "integer");
  CHECK(begins["responses"]["200"]["content"]["application/json"]["schema"]["$ref"] ==
        "#/components/schemas/Job");
  CHECK(begins["responses"]["default"]["$ref"] == "#/components/responses/Refused");
  const auto& jobs = document["paths"]["/api/jobs"]["get"]["responses"]["200"]["content"]
                             ["application/json"]["schema"];
  CHECK(jobs["type"] == "array");
  CHECK(jobs["items"]["$ref"] == "#/components/schemas/Job");
  const auto& lamp = document["paths"]["/api/lamp/{n}.jpg"]["get"];
  CHECK(lamp["responses"].contains("204"));
  CHECK(lamp["responses"]["200"]["content"].contains("image/jpeg"));
  const auto& n = lamp["parameters"][0];
  CHECK(n["name"] == "n");
  CHECK(n["in"] == "path");
  CHECK(n["required"] == true);
  CHECK(n["schema"]["enum"].size() == 2);
  CHECK(lamp["parameters"][1]["name"] == "size");
  CHECK(lamp["parameters"][1]["required"] == false);
}

TEST_CASE("Schemas in short are written out: names, arrays, what may be null or left out") {
  const auto document = nlohmann::json::parse(ApiDescription(kFrame).text());
  const auto& job = document["components"]["schemas"]["Job"];
  CHECK(job["type"] == "object");
  CHECK(job["required"] == nlohmann::json{"name", "left_s"});
  CHECK(job["properties"]["name"]["$ref"] == "#/components/schemas/Name");
  CHECK(job["properties"]["ended"]["oneOf"][0]["$ref"] == "#/components/schemas/Name");
  CHECK(job["properties"]["ended"]["oneOf"][1]["type"] == "null");
  CHECK(job["properties"]["left_s"]["type"] == nlohmann::json{"number", "null"});
  CHECK(job["properties"]["left_s"]["description"] == "to go");
  const auto& all = document["components"]["schemas"]["All"];
  CHECK(all["type"] == nlohmann::json{"object", "null"});
  CHECK(all["properties"]["jobs"]["type"] == nlohmann::json{"array", "null"});
  CHECK(all["properties"]["jobs"]["items"]["$ref"] == "#/components/schemas/Job");
  CHECK(all["properties"]["rows"]["items"]["type"] == "object");
}

TEST_CASE("Each request of the console is listed once, and all but a stop has what answers it") {
  std::set<std::string> met;
  for (const Endpoint& endpoint : endpoints()) {
    INFO(endpoint.request);
    CHECK(met.insert(endpoint.request).second);
    CHECK((endpoint.answer == nullptr) == (std::string(endpoint.request) == "POST /api/stop"));
  }
}

}  // namespace
}  // namespace planar
