#include "planar_servo/base/io/yaml_writer.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "planar_servo/base/io/checksum.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

TEST_CASE("Numbers come back bit for bit") {
  const std::vector<double> values{0.1, 1.0 / 3.0, -1e-300, 6.02214076e23,
                                   std::numeric_limits<double>::denorm_min()};
  YamlWriter writer("map", "a-test");
  writer.add("values", values);
  writer.map("nested", [&] { writer.add("one", values[1]); });
  const test::TemporaryFolder folder;
  YamlReader reader(folder.write("m.yaml", writer.text()), "map");
  std::vector<double> read;
  double one = 0.0;
  reader.numbers("values", read, values.size());
  reader.map("nested", [&] { reader.number("one", one); });
  CHECK(read == values);
  CHECK(one == values[1]);
  CHECK_NOTHROW(reader.throw_if_faulty());
}

TEST_CASE("Texts come back whatever they contain, by themselves and in a list") {
  std::vector<std::string> texts{"plain",      "with: colon",
                                 "#hash",      "a #hash",
                                 "quo\"te\\",  "",
                                 " lead",      "trail ",
                                 "no",         "Yes",
                                 "null",       "~",
                                 "true",       "1.0",
                                 "1e3",        "0x1F",
                                 ".nan",       "12:30:00",
                                 "a: b",       "key:",
                                 "- item",     "-1",
                                 "--- ",       "...",
                                 "a, b",       "[a]",
                                 "{a: b}",     "a]",
                                 "two\nlines", "tab\t",
                                 "\n",         "a\r\nb",
                                 "'quoted'",   "&anchor",
                                 "*alias",     "!tag",
                                 "| block",    "> fold",
                                 "%TAG",       "@at",
                                 "`tick`",     "? key",
                                 "a,b.png",    "\xC3\xA9\xE2\x82\xAC.png",
                                 "<<",         "=",
                                 "2026-11-21"};
  std::mt19937 random(7);
  const std::string alphabet = "ab01 :#,-[]{}'\"\\\n\t&*!|>%@`?.~";
  for (int i = 0; i < 500; ++i) {
    std::string text(random() % 8, ' ');
    for (char& c : text) c = alphabet[random() % alphabet.size()];
    texts.push_back(text);
  }
  YamlWriter writer("map", "a-test");
  for (std::size_t i = 0; i < texts.size(); ++i) writer.add("t" + std::to_string(i), texts[i]);
  writer.add("all", texts);
  const test::TemporaryFolder folder;
  YamlReader reader(folder.write("m.yaml", writer.text()), "map");
  for (std::size_t i = 0; i < texts.size(); ++i) {
    std::string text;
    reader.text("t" + std::to_string(i), text);
    CHECK(text == texts[i]);
  }
  std::vector<std::string> all;
  reader.texts("all", all);
  CHECK(all == texts);
  CHECK_NOTHROW(reader.throw_if_faulty());
}

TEST_CASE("A text that another reader would take for something else stands in quotes") {
  for (const char* text : {"no", "null", "true", "1.0", "~", "", "2026-11-21"}) {
    YamlWriter writer;
    writer.add("text", text);
    CHECK(writer.text() == std::string("text: \"") + text + "\"\n");
  }
  YamlWriter writer;
  writer.add("text", "planar-servo/map/1");
  CHECK(writer.text() == "text: planar-servo/map/1\n");
}

TEST_CASE("Maps stand in blocks, lists of numbers on a line each") {
  YamlWriter writer;
  writer.add("count", 3).add("gain", 0.5).add("used", true);
  writer.map("fit", [&] { writer.add("rejected", std::vector<std::string>{"a", "b,c"}); });
  writer.add("hull", std::vector<std::vector<double>>{{0.25, -1.0}, {1e-9, 2.0}});
  std::vector<int> gears{50};
  writer.maps("drives", gears, [&](int gear) { writer.add("gear", gear); });
  writer.add("empty", std::vector<double>{}).add_inputs({});
  CHECK(writer.text() ==
        "count: 3\ngain: 0.5\nused: true\nfit:\n  rejected: [a, \"b,c\"]\n"
        "hull:\n  - [0.25, -1]\n  - [1e-09, 2]\ndrives:\n  - gear: 50\nempty: []\ninputs: []\n");
}

TEST_CASE("The hash of an input does not depend on when that input was made") {
  const test::TemporaryFolder folder;
  const auto inputs_text = [&](const std::string& created) {
    YamlWriter writer;
    writer.add_inputs(
        input_records({folder.write("in.yaml", "format: x\ncreated: " + created + "\na: 1\n")}));
    return writer.text();
  };
  CHECK(inputs_text("2020") == inputs_text("2021"));
  YamlWriter plain;
  plain.add_inputs(input_records({folder.write("in.csv", "abc")}));
  CHECK_THAT(plain.text(), Catch::Contains(sha256("abc")));
}

TEST_CASE("SHA-256 gives the standard's test vectors") {
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

}  // namespace
}  // namespace planar
