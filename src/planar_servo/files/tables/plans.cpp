#include "planar_servo/files/tables/plans.h"

#include <fmt/format.h>

namespace planar {
namespace {

constexpr char kColumn[] = "plan";

std::optional<Plan> plan_at(Columns& columns, const std::string& word) {
  const std::optional<Plan> plan = plan_named(word);
  if (!plan)
    columns.check(false,
                  fmt::format("plan is '{}'; allowed are {}", word, fmt::join(plan_names(), ", ")));
  return plan;
}

}  // namespace

void list_plan(Columns& columns, Plan& plan) {
  std::string word = name(plan);
  columns.text(kColumn, word);
  if (columns.reading()) plan = plan_at(columns, word).value_or(plan);
}

void list_optional_plan(Columns& columns, std::optional<Plan>& plan) {
  std::string word = plan ? name(*plan) : "";
  columns.text(kColumn, word, Column::kOptional);
  if (!columns.reading()) return;
  plan = word.empty() ? std::nullopt : plan_at(columns, word);
}

}  // namespace planar
