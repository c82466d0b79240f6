#include "planar_servo/base/io/columns.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

struct Row {
  std::string id;
  std::string note;
  Eigen::Vector2d p{0.0, 0.0};
  std::optional<Eigen::Vector2d> q;
  std::optional<double> variance;
  int count{0};
};

const TableSchema<Row> kSchema{
    "samples", [](Columns& columns, Row& row) {
      columns.text("id", row.id);
      columns.point("x_mm", "y_mm", row.p, kMillimetre, 3);
      columns.optional_point("qx_mm", "qy_mm", row.q, kMillimetre, 3, Column::kOptional);
      columns.optional_number("var", row.variance, 1.0, Digits::significant(3), Column::kRequired);
      columns.whole_number("count", row.count);
      columns.text("note", row.note, Column::kOptional);
      columns.check(row.count >= 0, {"count is negative"});
    }};

std::vector<Row> rows_in(const std::string& text) {
  const test::TemporaryFolder folder;
  TableFile<Row> table(folder.write("t.csv", text), kSchema);
  std::vector<Row> rows;
  for (Row row; table.next(row);) rows.push_back(row);
  table.throw_if_faulty();
  return rows;
}

TEST_CASE("A row is written as its columns say") {
  const Row row{"a", "far, far away", {0.001, -1e-9}, std::nullopt, 0.00123456, 3};
  CHECK(kSchema.header() ==
        "# format: planar-servo/samples/1\nid,x_mm,y_mm,qx_mm,qy_mm,var,count,note\n");
  CHECK(kSchema.line(row) == "a,1.000,0.000,,,0.00123,3,\"far, far away\"\n");
}

TEST_CASE("Only the required columns are needed, and what is not there is empty") {
  const std::vector<Row> rows = rows_in("count,var,id,x_mm,y_mm\n7,,a,1,2\n");
  CHECK(rows.at(0).p == Eigen::Vector2d(1.0 * kMillimetre, 2.0 * kMillimetre));
  CHECK(rows[0].count == 7);
  CHECK_FALSE(rows[0].variance.has_value());
  CHECK_FALSE(rows[0].q.has_value());
  CHECK(rows[0].note.empty());
  CHECK_THROWS_MATCHES(rows_in("id,x_mm,count\n"), InputError,
                       Refused(Cause::kMissing, "y_mm, var"));
}

TEST_CASE("A column that is probably one of ours is named with it, others are ignored") {
  CHECK_THROWS_MATCHES(rows_in("id,x_m,Y_mm,var,count\n"), InputError,
                       Refused(Cause::kMissing, "x_mm, y_mm"));
  CHECK_THROWS_MATCHES(rows_in("id,x_m,Y_mm,var,count\n"), InputError,
                       Refused(Cause::kMissing, "x_m is probably x_mm"));
  CHECK_THROWS_MATCHES(rows_in("id,x_mm,y_mm,var,count,qx_m,Note\n"), InputError,
                       Refused(Cause::kInvalid, "qx_m is probably qx_mm"));
  CHECK(rows_in("id,x_mm,y_mm,var,count,z_mm,x_m,remark\na,1,2,,7,3,0.001,r\n").size() == 1);
}

TEST_CASE("Values of a row before do not stay where a field is empty") {
  const std::string lines = kSchema.line({"a", "n", {1.0, 2.0}, Eigen::Vector2d(3.0, 4.0), 5.0, 6});
  const std::vector<Row> rows = rows_in(kSchema.header() + lines + kSchema.line({}));
  CHECK(rows.at(1).id.empty());
  CHECK(rows[1].note.empty());
  CHECK_FALSE(rows[1].q.has_value());
  CHECK_FALSE(rows[1].variance.has_value());
}

TEST_CASE(
    "All faults of a table are named, a point with half a place and broken rules among them") {
  const auto read = [] {
    rows_in("id,x_mm,y_mm,qx_mm,qy_mm,var,count\na,1,2,3,,0,1\nb,one,2,,,0,1.5\nc,1,2,,,0,-1\n");
  };
  CHECK_THROWS_MATCHES(read(), InputError, Refused(Cause::kInvalid, "t.csv:2: qy_mm"));
  CHECK_THROWS_MATCHES(read(), InputError, Refused(Cause::kInvalid, "t.csv:3: x_mm is 'one'"));
  CHECK_THROWS_MATCHES(read(), InputError, Refused(Cause::kInvalid, "t.csv:3: count is '1.5'"));
  CHECK_THROWS_MATCHES(read(), InputError, Refused(Cause::kInvalid, "t.csv:4: "));
}

TEST_CASE("Texts come back whatever they contain, and the rows behind them keep their lines") {
  std::mt19937 random(11);
  const auto text = [&] {
    constexpr const char* kParts[] = {"a",  ",", "\"", "#", " ",       "\n",
                                      "\r", ";", "\t", "'", "\xC3\xA9"};
    std::string parts;
    for (auto i = random() % 6; i > 0; --i) parts += kParts[random() % std::size(kParts)];
    return parts;
  };
  for (int table = 0; table < 100; ++table) {
    std::vector<Row> written;
    std::string lines = kSchema.header();
    for (int i = 0; i < 20; ++i) {
      Row row{text(), text(), {0.001 * i, 0.5}, std::nullopt, std::nullopt, i};
      if (i % 3 == 0) row.q = Eigen::Vector2d(0.25, -0.125);
      lines += kSchema.line(row);
      written.push_back(row);
    }
    const std::vector<Row> read = rows_in(lines);
    REQUIRE(read.size() == written.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      CHECK(read[i].id == written[i].id);
      CHECK(read[i].note == written[i].note);
      CHECK((read[i].p - written[i].p).norm() < 1e-12);
      CHECK(read[i].q == written[i].q);
      CHECK(read[i].count == written[i].count);
    }
    const auto ends = std::count(lines.begin(), lines.end(), '\n');
    CHECK_THROWS_MATCHES(rows_in(lines + "z,1,2,,,,x,\n"), InputError,
                         Refused(Cause::kInvalid, "t.csv:" + std::to_string(ends + 1) + ": count"));
  }
}

}  // namespace
}  // namespace planar
