#include <catch2/catch.hpp>

#include "planar_servo/base/core/text.h"

namespace planar {
namespace {

TEST_CASE("A word is nearest to the one that it misspells") {
  const std::vector<std::string> words{"cell", "targets", "no-error-map", "centre"};
  CHECK(nearest_word("cel", words) == "cell");
  CHECK(nearest_word("tagrets", words) == "targets");
  CHECK(nearest_word("no_error_map", words) == "no-error-map");
  CHECK(nearest_word("center", {"centre"}) == "centre");
  CHECK(nearest_word("targets", words) == "targets");
}

TEST_CASE("A word that is like none has no nearest one") {
  const std::vector<std::string> words{"x", "out", "cell", "targets"};
  for (const char* word : {"y", "cut-off", "nonsense", "ce", ""})
    CHECK(nearest_word(word, words).empty());
  CHECK(nearest_word("cell", {}).empty());
}

}  // namespace
}  // namespace planar
