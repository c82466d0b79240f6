#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/csv_table.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

/// A table of points as some program saved it.
struct Saved {
  explicit Saved(const std::string& text)
      : file(folder.write("points.csv", text), "targets", {"id", "x_mm"}) {}

  std::vector<double> numbers() {
    std::vector<double> all;
    while (file.next_row()) all.push_back(file.number("x_mm"));
    file.throw_if_faulty();
    return all;
  }

  test::TemporaryFolder folder;
  CsvFile file;
};

TEST_CASE("A table is read as spreadsheets save it") {
  for (const char* text :
       {"id,x_mm,,,\r\nA,200.5,,,\r\n,,,,\r\n,,,,\r\n", "sep=;\r\nid;x_mm\r\nA;200,5\r\n",
        "sep=,\nid,x_mm\nA,200.5\n", "id\tx_mm\r\nA\t200.5\r\n", "id;x_mm\nA;200,5\n",
        "\xEF\xBB\xBFid;x_mm;\nA;200,5;\n;;\n",
        "# format: planar-servo/targets/1,,\nid,x_mm,\nA,200.5,\n",
        "\"# format: planar-servo/targets/1\",,\n# a remark,,\nid,x_mm\nA,200.5\n"}) {
    INFO(text);
    CHECK(Saved(text).numbers() == std::vector<double>{200.5});
  }
}

TEST_CASE("A column that is misnamed is told from the others whatever separates them") {
  for (const char* header : {"Nr;x_mm\nA;1\n", "Nr\tx_mm\nA\t1\n", "Nr,x_mm\nA,1\n"})
    CHECK_THROWS_MATCHES(
        Saved(header), InputError,
        Refused(Cause::kMissing, "lacks the column id; needed are id, x_mm; it has Nr, x_mm"));
}

TEST_CASE("Letters as spreadsheets for Windows write them are read in UTF-8") {
  for (const char* text : {"id;x_mm\nLoch \xE4;1\n", "id;x_mm\nLoch \xC3\xA4;1\n"}) {
    Saved saved(text);
    REQUIRE(saved.file.next_row());
    CHECK(saved.file.text("id") == "Loch \xC3\xA4");
  }
}

TEST_CASE("What is no table in text is named by its kind") {
  const std::pair<const char*, const char*> kinds[] = {
      {"\xFF\xFEi", "UTF-16"},  {"PK\x03\x04", ".xlsx"},   {"G21\nG90\nG0 X200 Y100\n", "G-code"},
      {"%\nO1000\n", "G-code"}, {"N10 G0 X1\n", "G-code"}, {"0\nSECTION\n2\nENTITIES\n", "DXF"}};
  for (const auto& [text, kind] : kinds)
    CHECK_THROWS_MATCHES(Saved(text), InputError, Refused(Cause::kInvalid, kind));
  CHECK_THROWS_MATCHES(Saved("# format: planar-servo/pairs/1,,\nid,x_mm\n"), InputError,
                       Refused(Cause::kForeign, "planar-servo/pairs/1"));
}

TEST_CASE("A table with tabs whose first column is called as a code of a program is no program") {
  CHECK(Saved("M1\tid\tx_mm\n7\tA\t200.5\n").numbers() == std::vector<double>{200.5});
}

TEST_CASE("What only looks like a number is named, and commas in numbers are told from columns") {
  CHECK_THROWS_MATCHES(Saved("id,x_mm\nA,\xE2\x88\x92"
                             "200\n")
                           .numbers(),
                       InputError, Refused(Cause::kInvalid, "U+2212"));
  CHECK_THROWS_MATCHES(Saved("id,x_mm\nA,1\xC2\xA0"
                             "200\n")
                           .numbers(),
                       InputError, Refused(Cause::kInvalid, "U+00A0"));
  CHECK_THROWS_MATCHES(Saved("id,x_mm\nA,200,5\n").numbers(), InputError,
                       Refused(Cause::kInvalid, "semicolons"));
}

}  // namespace
}  // namespace planar
