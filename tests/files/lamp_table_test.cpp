#include "planar_servo/files/tables/pair_table.h"

#include <catch2/catch.hpp>

#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("A row with both lamps comes back with its covariances and position") {
  LampRow row;
  row.id = "t1";
  row.image = "images/t1.pgm";
  row.t_s = 2.25;
  row.status = LampStatus::kOk;
  row.uv_px = {{100.125, 200.5}, {300.0, 400.0}};
  row.covariance_px2.assign(2, (Eigen::Matrix2d() << 1e-4, 2e-5, 2e-5, 3e-4).finished());
  row.looks.assign(2, {180.0, 12.0, 0.85, 0.97});
  row.p_vision = Eigen::Vector2d(0.1, -0.2);
  row.phi = 0.25;
  row.sigma = Eigen::Vector2d(1e-6, 2e-6);
  const test::TemporaryFolder folder;
  const LampRow back = read_lamps(folder.write("lamps.csv", lamps_text({row}))).at(0);
  REQUIRE(back.uv_px.size() == 2);
  CHECK(back.uv_px[0] == row.uv_px[0]);
  CHECK((back.covariance_px2[1] - row.covariance_px2[1]).norm() < 1e-8);
  REQUIRE(back.looks.size() == 2);
  CHECK(back.looks[1].blur_px == 0.85);
  CHECK((*back.p_vision - *row.p_vision).norm() < 1e-9);
  CHECK(*back.phi == Approx(0.25).margin(1e-8));
}

TEST_CASE("A failed image keeps its row and its reason, a single disc its one centre") {
  LampRow failed;
  failed.id = "t1";
  failed.status = LampStatus::kNoLamp;
  LampRow disc;
  disc.id = "t2";
  disc.status = LampStatus::kOk;
  disc.uv_px = {{5.0, 6.0}};
  disc.covariance_px2.push_back(Eigen::Matrix2d::Identity());
  const test::TemporaryFolder folder;
  const auto rows = read_lamps(folder.write("lamps.csv", lamps_text({failed, disc})));
  CHECK(rows.at(0).status == LampStatus::kNoLamp);
  CHECK(rows.at(0).uv_px.empty());
  CHECK(rows.at(1).uv_px.size() == 1);
  CHECK_FALSE(rows.at(1).p_vision.has_value());
}

TEST_CASE("A table says by which fixed lamps its pixels are corrected, beside its rows") {
  const test::TemporaryFolder folder;
  LampRow row;
  row.id = "t1";
  const std::vector<ReferenceLamp> lamps{{"R1", {4936.123456789, 70.5}, 0.0079},
                                         {"over the door", {1.0, 2.0}, 0.01}};
  const std::vector<Origin> origins{{Role::kCamera, "camera.yaml", std::string(64, 'a')}};
  const auto file = folder.write("lamps.csv", lamps_text({row}, lamp_remarks(origins, lamps)));
  const auto back = read_reference_remarks(file);
  REQUIRE(back.size() == 2);
  CHECK(back[0].uv_px == lamps[0].uv_px);
  CHECK(back[0].sigma_px == lamps[0].sigma_px);
  CHECK(back[1].id == "over the door");
  CHECK(read_lamps(file).size() == 1);
  REQUIRE(read_origins(file).size() == 1);
  CHECK(read_reference_remarks(folder.write("bare.csv", lamps_text({row}))).empty());
}

TEST_CASE("A status that no lamp can have is refused with those that there are") {
  const test::TemporaryFolder folder;
  LampRow row;
  row.id = "t1";
  std::string text = lamps_text({row});
  text.replace(text.find("no_lamp"), 7, "gone");
  CHECK_THROWS_MATCHES(read_lamps(folder.write("lamps.csv", text)), InputError,
                       Refused(Cause::kInvalid, "lamps.csv:3: status"));
}

}  // namespace
}  // namespace planar
