#include "planar_servo/files/learned_arm_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/files/arm_file.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {
namespace {

constexpr char kLearnedKind[] = "arm_learned";
constexpr std::size_t kShownHash = 8;

/// Visits the lower triangle of a covariance of so many terms, row after row.
void list_covariance(Fields& fields, Eigen::MatrixXd& covariance, Eigen::Index terms) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) values.push_back(covariance(i, j));
  const auto n = static_cast<std::size_t>(terms * (terms + 1) / 2);
  if (!fields.numbers("covariance", values, n) || !fields.reading()) return;
  covariance.resize(terms, terms);
  auto value = values.begin();
  for (Eigen::Index i = 0; i < terms; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) covariance(i, j) = covariance(j, i) = *value++;
  fields.check((covariance.diagonal().array() >= 0.0).all(),
               "covariance has a diagonal element below 0", "covariance");
}

void list_learned_arm(Fields& fields, LearnedArm& learned) {
  fields.map("arm", [&] { list_found_arm(fields, learned.arm); });
  list_covariance(fields, learned.covariance, learned.arm.x.size());
}

}  // namespace

std::vector<Origin> learned_arm_origins(const CellSettings& cell) {
  return {origin_of({Role::kArmFound, cell.arm_found.value()}),
          origin_of({Role::kErrorMap, cell.error_map})};
}

std::string learned_arm_text(const LearnedArm& learned, const std::vector<Origin>& origins,
                             const std::string& program) {
  YamlWriter yaml(kLearnedKind, program);
  yaml.add_inputs(input_records(origins));
  LearnedArm written = learned;
  list_learned_arm(yaml, written);
  return yaml.text();
}

LearnedArm read_learned_arm(const std::filesystem::path& path) {
  YamlReader reader(path, kLearnedKind);
  LearnedArm learned;
  list_learned_arm(reader, learned);
  reader.throw_if_faulty();
  return learned;
}

std::optional<std::string> learned_elsewhere(const std::filesystem::path& path,
                                             const std::vector<Origin>& origins) {
  const std::vector<Origin> made_from = read_origins(path);
  for (const Origin& present : origins) {
    const auto same_role = [&](const Origin& origin) { return origin.role == present.role; };
    const auto then = std::find_if(made_from.begin(), made_from.end(), same_role);
    if (then == made_from.end())
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
