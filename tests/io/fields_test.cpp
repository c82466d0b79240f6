#include "planar_servo/base/io/fields.h"

#include <array>
#include <catch2/catch.hpp>
#include <optional>
#include <random>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

enum class Law { kJacobian, kInverse };
constexpr Named<Law> kLaws[] = {{Law::kJacobian, "jacobian"}, {Law::kInverse, "inverse"}};

struct Bump {
  double place{0.0};
  int order{1};
};

struct Drive {
  std::string name;
  double gear{1.0};
};

struct Settings {
  Law law{Law::kJacobian};
  double gain{1.0};
  double settle_s{0.0};
  int frames{1};
  std::uint32_t seed{0};
  std::string note;
  std::optional<double> noise;
  std::array<double, 3> offsets{};
  std::vector<double> weights;
  std::vector<std::string> images;
  std::vector<Bump> bumps;
  std::array<Law, 2> laws{};
  std::array<Bump, 2> limits{};
  std::array<Drive, 2> drives;
  std::vector<Drive> spares;
};

void list_drive(Fields& fields, Drive& drive) {
  fields.text("name", drive.name);
  fields.number("gear", drive.gear, 1.0, Range::positive());
}

void list_bump(RowFields& row, Bump& bump) {
  row.number(bump.place, kMillimetre);
  row.whole_number(bump.order, 0, 1000);
}

void list_fields(Fields& fields, Settings& settings) {
  fields.choice("law", settings.law, kLaws);
  fields.number("gain", settings.gain, 1.0, Range::positive(1.0));
  fields.number("settle_ms", settings.settle_s, kMillimetre, Range::at_least(0.0));
  fields.whole_number("frames", settings.frames, 1, 100);
  fields.whole_number("seed", settings.seed, std::uint32_t{0});
  if (fields.given("note", !settings.note.empty())) fields.text("note", settings.note);
  if (fields.given("noise_mm", settings.noise.has_value())) {
    double noise = settings.noise.value_or(0.0);
    if (fields.number("noise_mm", noise, kMillimetre)) settings.noise = noise;
  }
  fields.map("arm", [&] {
    fields.numbers("offsets", settings.offsets);
    fields.row("ends", [&](RowFields& row) {
      row.number(settings.limits[0].place);
      row.number(settings.limits[1].place);
    });
    fields.numbers("weights", settings.weights, 0, kMillimetre);
  });
  fields.texts("images", settings.images);
  fields.rows("bumps", settings.bumps, list_bump);
  fields.choices("laws", settings.laws, kLaws);
  const bool read = fields.rows("limits", settings.limits, list_bump);
  fields.check(!read || settings.limits[0].place <= settings.limits[1].place,
               {"the limits are in the wrong order"}, "limits");
  const auto list = [&](Drive& drive) { list_drive(fields, drive); };
  fields.maps("drives", settings.drives, list);
  fields.maps("spares", settings.spares, list);
}

std::string text_of(Settings settings) {
  YamlWriter writer("settings", "a-test");
  list_fields(writer, settings);
  return writer.text();
}

Settings settings_in(const std::string& text) {
  const test::TemporaryFolder folder;
  YamlReader reader(folder.write("settings.yaml", text), "settings");
  Settings settings;
  list_fields(reader, settings);
  reader.throw_if_faulty();
  return settings;
}

/// Everything in a text, but for the time at which it was written.
std::string lasting(const std::string& text) {
  return text.substr(text.find("law:"));
}

class RandomSettings {
 public:
  explicit RandomSettings(unsigned seed) : random_(seed) {}

  Settings draw() {
    Settings s;
    s.law = below(2) == 0 ? Law::kInverse : Law::kJacobian;
    s.gain = std::uniform_real_distribution<>(0.001, 1.0)(random_);
    s.settle_s = below(1000) * kMillimetre;
    s.frames = 1 + below(100);
    s.seed = static_cast<std::uint32_t>(random_());
    s.note = text();
    if (below(2) == 0) s.noise = number();
    for (double& offset : s.offsets) offset = number();
    for (int i = below(4); i > 0; --i) {
      s.weights.push_back(number());
      s.images.push_back(text());
      s.bumps.push_back({number(), below(1000)});
      s.spares.push_back({text(), 0.5});
    }
    s.laws = {Law::kInverse, Law::kJacobian};
    s.limits = {Bump{-1.0, 1}, Bump{1.0, 2}};
    for (Drive& drive : s.drives) drive = {text(), 50.0};
    return s;
  }

 private:
  int below(int n) { return std::uniform_int_distribution<>(0, n - 1)(random_); }
  double number() { return std::ldexp(std::normal_distribution<>()(random_), below(60) - 30); }
  std::string text() {
    constexpr const char* kParts[] = {"a", ",", "\"", "#", " ", ": ", "\n", "\xC3\xA9", "no", "1"};
    std::string text;
    for (int i = below(5); i > 0; --i) text += kParts[below(10)];
    return text;
  }

  std::mt19937 random_;
};

TEST_CASE("Settings written and read again are the same, whatever they contain") {
  RandomSettings random(3);
  for (int i = 0; i < 200; ++i) {
    const Settings written = random.draw();
    const Settings read = settings_in(text_of(written));
    CHECK(read.law == written.law);
    CHECK(read.gain == written.gain);
    CHECK(read.seed == written.seed);
    CHECK(read.note == written.note);
    CHECK(read.noise.has_value() == written.noise.has_value());
    CHECK(read.offsets == written.offsets);
    CHECK(read.images == written.images);
    CHECK(read.laws == written.laws);
    CHECK(read.drives[1].name == written.drives[1].name);
    REQUIRE(read.spares.size() == written.spares.size());
    REQUIRE(read.bumps.size() == written.bumps.size());
    for (std::size_t k = 0; k < read.bumps.size(); ++k) {
      CHECK(read.spares[k].name == written.spares[k].name);
      CHECK(read.bumps[k].order == written.bumps[k].order);
      CHECK(read.bumps[k].place == Approx(written.bumps[k].place).epsilon(1e-15));
    }
  }
}

InputError faults_of(const std::string& from, const std::string& to) {
  std::string text = text_of(RandomSettings(1).draw());
  const std::size_t begin = text.find("\n" + from) + 1;
  REQUIRE(begin != 0);
  text.replace(begin, text.find('\n', begin) - begin, to);
  try {
    settings_in(text);
  } catch (const InputError& e) {
    return e;
  }
  return InputError("nothing");
}

TEST_CASE("What breaks a field's rule is one fault with its place") {
  CHECK_THAT(faults_of("law:", "law: magic"), Refused(Cause::kInvalid, "law is 'magic'"));
  CHECK_THAT(faults_of("gain:", "gain: 2"), Refused(Cause::kInvalid, "gain is 2"));
  CHECK_THAT(faults_of("frames:", "frames: 2.9"), Refused(Cause::kInvalid, "frames is 2.9"));
  CHECK_THAT(faults_of("  offsets:", "  offsets: [1, 2]"), Refused(Cause::kInvalid, "arm.offsets"));
  CHECK_THAT(faults_of("laws:", "laws: [jacobian, magic]"), Refused(Cause::kInvalid, "laws[1]"));
  const InputError fraction = faults_of("  - [-1000, 1]", "  - [-1000, 1.5]");
  CHECK_THAT(fraction, Refused(Cause::kInvalid, "limits[0][1] is 1.5"));
  CHECK(fraction.refusals().size() == 1);
  CHECK_THAT(faults_of("  - [-1000, 1]", "  - [2000, 1]"),
             Refused(Cause::kInvalid, ": the limits"));
  CHECK_THAT(faults_of("    gear:", "    gear: 0"), Refused(Cause::kInvalid, "drives[0].gear"));
  const InputError misspelt = faults_of("seed:", "sede: 1");
  CHECK_THAT(misspelt, Refused(Cause::kInvalid, "'sede'"));
  CHECK_THAT(misspelt, Refused(Cause::kMissing, "'seed'"));
}

TEST_CASE("Writing does not change what was written") {
  Settings settings = RandomSettings(5).draw();
  const std::string once = lasting(text_of(settings));
  YamlWriter writer;
  list_fields(writer, settings);
  CHECK(lasting(text_of(settings)) == once);
}

}  // namespace
}  // namespace planar
