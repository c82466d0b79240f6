#include "planar_servo/io/yaml_writer.h"

#include <catch2/catch.hpp>
#include <limits>

#include "planar_servo/io/sha256.h"
#include "planar_servo/io/yaml_reader.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

TEST_CASE("Numbers come back bit for bit") {
  const std::vector<double> values{0.1, 1.0 / 3.0, -1e-300, 6.02214076e23,
                                   std::numeric_limits<double>::denorm_min()};
  YamlWriter writer = YamlWriter::with_header("map", "a-test");
  writer.add("values", values);
  writer.begin_map("nested").add("one", values[1]).end_map();
  const test::TemporaryFolder folder;
  const YamlDocument document = YamlDocument::read(folder.write("m.yaml", writer.text()), "map");
  CHECK(document.root().numbers("values", values.size()) == values);
  CHECK(document.root().child("nested").number("one") == values[1]);
  CHECK_NOTHROW(document.throw_if_faulty());
}

TEST_CASE("Texts come back whatever they contain") {
  for (const std::string text :
       {"plain", "with: colon", "#hash", "quo\"te\\", "", "true", " lead"}) {
    YamlWriter writer = YamlWriter::with_header("map", "a-test");
    writer.add("text", text);
    const test::TemporaryFolder folder;
    CHECK(YamlDocument::read(folder.write("m.yaml", writer.text()), "map").root().text("text") ==
          text);
  }
}

TEST_CASE("The hash of an input does not depend on when that input was made") {
  const test::TemporaryFolder folder;
  const auto inputs_text = [&](const std::string& created) {
    YamlWriter writer;
    writer.add_inputs({folder.write("in.yaml", "format: x\ncreated: " + created + "\na: 1\n")});
    return writer.text();
  };
  CHECK(inputs_text("2020") == inputs_text("2021"));
  YamlWriter plain;
  plain.add_inputs({folder.write("in.csv", "abc")});
  CHECK_THAT(plain.text(), Catch::Contains(sha256("abc")));
}

TEST_CASE("SHA-256 gives the standard's test vectors") {
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

}  // namespace
}  // namespace planar
