#include "planar_servo/files/tables/pair_table.h"

#include <catch2/catch.hpp>

#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

TEST_CASE("Pairs come back as they were written") {
  PairRow row;
  row.id = "p1";
  row.p_vision = {0.1234567, -0.3};
  row.p_tracker = {0.1230, -0.2999};
  row.phi = 0.5;
  row.plan = Plan::kTrain;
  const test::TemporaryFolder folder;
  const PairRow back = read_pairs(folder.write("pairs.csv", pairs_text({row}))).at(0);
  CHECK(back.id == "p1");
  CHECK((back.error() - row.error()).norm() < test::kWrittenNanometre);
  CHECK(*back.phi == Approx(0.5).margin(1e-8));
  CHECK_FALSE(back.sigma_vision.has_value());
  CHECK(back.plan == Plan::kTrain);
}

}  // namespace
}  // namespace planar
