#include "planar_servo/experiment/campaign.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

namespace planar {
namespace {

/// Rows whose error of our chain is 1, 2, ... hundredths of a millimetre.
std::vector<nlohmann::json> numbered_rows(int count) {
  std::vector<nlohmann::json> rows;
  for (int i = 1; i <= count; ++i)
    rows.push_back(
        {{"seed", 500U + static_cast<unsigned>(i)},
         {"targets", 100},
         {"after_mean_mm_truth", 0.01 * i},
         {"after_p95_mm_truth", 0.02 * i},
         {"after_max_mm_truth", 0.03 * i},
         {"predicted_mean_mm", 0.01},
         {"predicted_p95_mm", 0.02},
         {"paper_chain", {{"before_mean_mm_truth", 1.5}, {"after_mean_mm_truth", 0.2}}}});
  return rows;
}

TEST_CASE("A campaign's figures are medians with their intervals, sums and the worst cell") {
  const nlohmann::json json = campaign_json(numbered_rows(10));
  CHECK(json["seeds"] == 10);
  CHECK(json["targets"] == 1000.0);
  CHECK(json["after_mean_mm_truth"].get<double>() == Approx(0.055));
  CHECK(json["worst_after_mean_mm_truth"].get<double>() == Approx(0.10));
  CHECK(json["median_95"]["after_mean_mm_truth"][0].get<double>() == Approx(0.02));
  CHECK(json["median_95"]["after_mean_mm_truth"][1].get<double>() == Approx(0.09));
  CHECK_FALSE(json["median_95"].contains("targets"));
  CHECK(json["cells"].size() == 10);
}

TEST_CASE("Five cells give a median but no 95 % interval of it, and say so") {
  CHECK(campaign_json(numbered_rows(5))["median_95"].empty());
  CHECK_THAT(campaign_text(numbered_rows(5)),
             Catch::Matches("[^]*95 % interval of the median +–[^]*"));
  CHECK_THAT(campaign_text(numbered_rows(10)), Catch::Contains("0.0200 to 0.0900"));
}

TEST_CASE("A figure that one cell lacks has no median") {
  auto rows = numbered_rows(3);
  rows[1]["turn_taken_out_deg"] = 0.2;
  rows[0]["turn_taken_out_deg"] = nullptr;
  rows[2]["turn_taken_out_deg"] = 0.2;
  CHECK_FALSE(campaign_json(rows).contains("turn_taken_out_deg"));
}

}  // namespace
}  // namespace planar
