#include "planar_servo/files/arm_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/files/matrix_fields.h"

namespace planar {
namespace {

/// Sines of motors 1 to 3, then cosines, of one order.
using Wave = std::array<double, 6>;

struct NamedTerms {
  explicit NamedTerms(const FoundArm& arm)
      : links(arm.x.head<2>()),
        zeros(arm.x.segment<3>(2)),
        runout(arm.x.segment<2>(arm.form.runout())),
        deviation(arm.x.tail(2 * arm.form.posture.terms())) {
    for (int i = 0; i < arm.form.waves(); ++i) {
      Wave wave{};
      const auto first = arm.x.begin() + ArmForm::kFirstWave + Eigen::Index{6} * i;
      std::copy(first, first + 6, wave.begin());
      (i < arm.form.harmonics ? eccentricity : ripple).push_back(wave);
    }
  }

  Eigen::VectorXd x() const {
    Eigen::VectorXd all(7 + 6 * (eccentricity.size() + ripple.size()) + deviation.size());
    all.head<5>() << links, zeros;
    Eigen::Index at = ArmForm::kFirstWave;
    for (const auto* waves : {&eccentricity, &ripple})
      for (const Wave& wave : *waves) {
        all.segment<6>(at) = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(wave.data());
        at += 6;
      }
    all.segment<2>(at) = runout;
    all.tail(deviation.size()) = deviation;
    return all;
  }

  Eigen::Vector2d links;
  Eigen::Vector3d zeros;
  Eigen::Vector2d runout;
  Eigen::VectorXd deviation;
  std::vector<Wave> eccentricity{}, ripple{};
};

void list_deviation(Fields& fields, PostureBasis& posture, Eigen::VectorXd& weights) {
  std::vector<Eigen::Vector3d> centers;
  for (const auto& center : posture.centers.colwise()) centers.emplace_back(center);
  fields.number("width", posture.width, 1.0, Range::positive());
  fields.rows("centers", centers);
  if (fields.reading()) {
    posture.centers.resize(3, static_cast<Eigen::Index>(centers.size()));
    for (std::size_t i = 0; i < centers.size(); ++i)
      posture.centers.col(static_cast<Eigen::Index>(i)) = centers[i];
    weights.resize(2 * posture.terms());
  }
  fields.numbers("weights_mm", weights, kMillimetre);
}

void list_found_arm(Fields& fields, FoundArm& arm) {
  NamedTerms terms(arm);
  fields.numbers("link_lengths_mm", terms.links, kMillimetre, Range::positive());
  fields.numbers("zero_offsets_deg", terms.zeros, kDegree);
  fields.rows("eccentricity_deg", terms.eccentricity, kDegree);
  if (fields.given("ripple_deg", !terms.ripple.empty()))
    fields.rows("ripple_deg", terms.ripple, kDegree);
  if (fields.given("runout3_mm", !terms.runout.isZero(0.0)))
    fields.numbers("runout3_mm", terms.runout, kMillimetre);
  if (fields.given("deviation", arm.form.posture.terms() > 0))
    fields.map("deviation", [&] { list_deviation(fields, arm.form.posture, terms.deviation); });
  if (fields.given("scatter_mm", arm.scatter_m > 0.0))
    fields.number("scatter_mm", arm.scatter_m, kMillimetre, Range::positive());
  if (fields.given("wander_mm", arm.wander_m > 0.0))
    fields.number("wander_mm", arm.wander_m, kMillimetre, Range::positive());
  arm.form.harmonics = static_cast<int>(terms.eccentricity.size());
  arm.form.ripples = static_cast<int>(terms.ripple.size());
  arm.x = terms.x();
  if (fields.given("factor", arm.factor.size() > 0))
    list_columns(fields, "factor", arm.factor, arm.x.size());
}

void add_terms(YamlWriter& yaml, std::vector<ArmTerm> terms) {
  yaml.maps("terms", terms, [&](const ArmTerm& term) {
    yaml.add("name", term.key);
    yaml.add("value", term.value / term.unit);
    yaml.add("sigma", term.sigma / term.unit);
    yaml.add("determined", term.determined);
  });
}

constexpr char kLearnedKind[] = "arm_learned";
constexpr std::size_t kShownHash = 8;

void list_learned_arm(Fields& fields, LearnedArm& learned) {
  fields.map("arm", [&] { list_found_arm(fields, learned.arm); });
  Eigen::MatrixXd& covariance = learned.covariance;
  if (!list_lower_triangle(fields, "covariance", covariance, learned.arm.x.size())) return;
  covariance = Eigen::MatrixXd(covariance.selfadjointView<Eigen::Lower>());
  fields.check((covariance.diagonal().array() >= 0.0).all(),
               {"covariance has a diagonal element below 0"}, "covariance");
}

}  // namespace

std::string found_arm_text(const FoundArm& arm, const std::vector<ArmTerm>& terms,
                           const std::vector<Origin>& origins, const std::string& program) {
  YamlWriter yaml("arm", program);
  yaml.add_inputs(input_records(origins));
  FoundArm written = arm;
  yaml.map("arm", [&] { list_found_arm(yaml, written); });
  add_terms(yaml, terms);
  return yaml.text();
}

FoundArm read_found_arm(const std::filesystem::path& path) {
  YamlReader reader(path, "arm");
  reader.map("terms", [&] { reader.allow_rest(); });
  FoundArm arm;
  reader.map("arm", [&] { list_found_arm(reader, arm); });
  reader.throw_if_faulty();
  return arm;
}

std::vector<Origin> learned_arm_origins(const CellSettings& cell) {
  return {origin_of({Role::kArmFound, cell.arm_found.value()}),
          origin_of({Role::kErrorMap, cell.error_map})};
}

std::string learned_arm_text(const LearnedArm& learned, const std::vector<Origin>& origins,
                             const std::string& program) {
  return record_text(kLearnedKind, learned, origins, program, list_learned_arm);
}

LearnedArm read_learned_arm(const std::filesystem::path& path) {
  return read_record<LearnedArm>(kLearnedKind, path, list_learned_arm);
}

std::optional<std::string> learned_elsewhere(const std::filesystem::path& path,
                                             const std::vector<Origin>& origins) {
  const std::vector<Origin> made_from = read_origins(path);
  for (const Origin& present : origins) {
    const Origin* const then = find_role(made_from, present.role);
    if (then == nullptr)
      return fmt::format("{}: does not say with which {} it was learned", path.string(),
                         present.name);
    if (then->sha256 != present.sha256)
      return fmt::format("{}: was learned with {} {}..., this one is {}...", path.string(),
                         then->name, then->sha256.substr(0, kShownHash),
                         present.sha256.substr(0, kShownHash));
  }
  return std::nullopt;
}

}  // namespace planar
