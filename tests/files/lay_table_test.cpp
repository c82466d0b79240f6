#include "planar_servo/tables/lay_table.h"

#include <catch2/catch.hpp>

#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

TEST_CASE("Lays come back as they were written") {
  const LayRow row{"plane_grid_00_0", {0.05, -0.1}, {0.1234567, -0.3}, 1.5e-6, false};
  const test::TemporaryFolder folder;
  const LayRow back = read_lays(folder.write("lays.csv", lays_text({row}))).at(0);
  CHECK(back.lay == row.lay);
  CHECK((back.p_board - row.p_board).norm() < test::kWrittenNanometre);
  CHECK((back.p_seen - row.p_seen).norm() < test::kWrittenNanometre);
  CHECK(back.sigma == Approx(row.sigma).margin(test::kWrittenNanometre));
  CHECK_FALSE(back.pitch_known);
}

TEST_CASE("A board's pitch is known unless the table says otherwise, in one of two words") {
  const std::string columns = "lay,x_board_mm,y_board_mm,x_seen_mm,y_seen_mm,sigma_mm";
  const test::TemporaryFolder folder;
  CHECK(read_lays(folder.write("lays.csv", columns + "\na,0,0,1,2,0.001\n")).at(0).pitch_known);
  CHECK_THROWS_WITH(read_lays(folder.write("lays.csv", columns + ",pitch\na,0,0,1,2,0.001,50\n"
                                                                 "a,0,0,1,2,-0.001,known\n")),
                    Catch::Contains("lays.csv:2:") && Catch::Contains("known, unknown") &&
                        Catch::Contains("lays.csv:3: sigma_mm is negative"));
}

}  // namespace
}  // namespace planar
