#include "planar_servo/files/work_file.h"

#include <fmt/format.h>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/files/matrix_fields.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Returns a word as files write it, whatever a person put between its parts.
std::string plain_kind(std::string word) {
  for (char& letter : word) {
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    if (letter == ' ' || letter == '-') letter = '_';
  }
  return word;
}

void list_kind(Columns& columns, Fiducial& mark) {
  std::string word = name_in(kFiducialKinds, mark.kind);
  columns.text("kind", word);
  if (!columns.reading()) return;
  const auto kind = value_named(kFiducialKinds, plain_kind(word));
  columns.check(kind.has_value(),
                {fmt::format("\"{}\" is no kind of mark", word),
                 "use one of " + fmt::format("{}", fmt::join(names_of(kFiducialKinds), ", "))},
                "kind");
  if (kind) mark.kind = *kind;
}

const TableSchema<Fiducial>& mark_schema() {
  static const TableSchema<Fiducial> schema{
      "work",
      [](Columns& columns, Fiducial& mark) {
        columns.text("id", mark.id);
        columns.point("x_mm", "y_mm", mark.p_W, kMillimetre, 6);
        list_kind(columns, mark);
        columns.number("size_mm", mark.size, kMillimetre, 6);
        std::optional<double> z = mark.z, sigma_z = mark.sigma_z;
        columns.optional_number("z_mm", z, kMillimetre, 6);
        columns.optional_number("sigma_z_mm", sigma_z, kMillimetre, 6);
        mark.z = z.value_or(0.0);
        mark.sigma_z = sigma_z.value_or(0.0);
        columns.check(mark.size > 0.0,
                      {fmt::format("size_mm is {:g}", mm(mark.size)), "it must be positive"},
                      "size_mm");
        columns.check(
            mark.sigma_z >= 0.0,
            {fmt::format("sigma_z_mm is {:g}", mm(mark.sigma_z)), "it must not be negative"},
            "sigma_z_mm");
        columns.check(
            mark.kind != FiducialKind::kAprilTag || tag_number(mark.id).has_value(),
            {"the id of an AprilTag must end with the tag's number", "write it as 7 or tag7"},
            "id");
      },
      UnendedRow::kWarned, RowIds::kOwn};
  return schema;
}

/// Refuses marks that lie on one another, and too few.
void require_apart(const std::vector<Fiducial>& marks, const fs::path& path) {
  Faults faults;
  if (marks.size() < 2)
    faults.add({"has one mark, which does not tell how the work is turned", "add one far from it",
                path.string(), Cause::kInsufficient});
  for (std::size_t i = 0; i < marks.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if ((marks[i].p_W - marks[k].p_W).norm() < 0.5 * (marks[i].size + marks[k].size))
        faults.add({fmt::format("{} and {} overlap", marks[k].id, marks[i].id),
                    "correct or leave out one of them", path.string(), Cause::kContradiction});
  faults.throw_if_any();
}

void list_fields(Fields& fields, FoundFiducial& found) {
  Fiducial& mark = found.fiducial;
  fields.text("id", mark.id);
  fields.choice("kind", mark.kind, kFiducialKinds);
  fields.numbers("drawn_mm", mark.p_W, kMillimetre);
  fields.number("size_mm", mark.size, kMillimetre, Range::positive());
  fields.number("z_mm", mark.z, kMillimetre);
  fields.number("sigma_z_mm", mark.sigma_z, kMillimetre, Range::at_least(0.0));
  fields.numbers("seen_px", found.uv_px);
  fields.numbers("seen_mm", found.p_B, kMillimetre);
  fields.numbers("residual_mm", found.residual, kMillimetre);
  fields.number("sigma_mm", found.sigma, kMillimetre, Range::at_least(0.0));
  if (fields.given("diameter_mm", found.diameter > 0.0))
    fields.number("diameter_mm", found.diameter, kMillimetre, Range::positive());
}

void list_fields(Fields& fields, FoundWork& work) {
  WorkPose& pose = work.pose;
  if (fields.given("id", !work.id.empty())) fields.text("id", work.id);
  fields.choice("map", pose.map, kWorkMaps);
  fields.numbers("origin_mm", pose.t, kMillimetre);
  std::array<Eigen::Vector2d, 2> rows{pose.A.row(0), pose.A.row(1)};
  fields.rows("matrix", rows);
  for (Eigen::Index i = 0; i < 2; ++i) pose.A.row(i) = rows[static_cast<std::size_t>(i)];
  fields.check(pose.scale() > 0.1 && pose.scale() < 10.0,
               {"matrix must map lengths to between a tenth and ten times of theirs"}, "matrix");
  list_covariance(fields, {"x_m", "y_m", "xx", "yx", "xy", "yy"}, pose.covariance);
  fields.number("chance", work.chance, 1.0, Range::from_to(0.0, 1.0));
  if (fields.given("remarks", !work.remarks.empty())) fields.texts("remarks", work.remarks);
  fields.maps("fiducials", work.fiducials,
              [&](FoundFiducial& found) { list_fields(fields, found); });
}

void list_fields(Fields& fields, LaidWorks& laid) {
  if (fields.given("exposure_ms", laid.exposure_s.has_value())) {
    if (fields.reading()) laid.exposure_s.emplace();
    fields.number("exposure_ms", *laid.exposure_s, kMillisecond, Range::positive());
  }
  fields.maps("works", laid.works, [&](FoundWork& work) {
    double turn = work.pose.turn(), scale = work.pose.scale();  // for people: the matrix says both
    fields.number("turn_deg", turn, kDegree);
    fields.number("scale", scale);
    list_fields(fields, work);
  });
  fields.check(!laid.works.empty(), {"names no work", "", "", Cause::kMissing});
}

}  // namespace

std::vector<Fiducial> read_work_drawing(const fs::path& path) {
  std::vector<Fiducial> marks =
      TableFile<Fiducial>(path, mark_schema()).rows("at least two marks are needed");
  require_apart(marks, path);
  return marks;
}

std::vector<Fiducial> read_bar(const std::filesystem::path& path) {
  std::vector<Fiducial> marks = read_work_drawing(path);
  if (marks.size() != 2)
    throw InputError({fmt::format("has {} marks", marks.size()), "a bar has two", path});
  return marks;
}

std::string work_text(const LaidWorks& laid, const std::vector<Origin>& origins,
                      const std::string& program) {
  return record_text("work", laid, origins, program, list_fields);
}

LaidWorks read_works(const fs::path& path) {
  auto laid = read_record<LaidWorks>("work", path, list_fields);
  laid.file = path;
  return laid;
}

std::vector<Origin> work_origins(const CellSettings& cell, const fs::path& drawing,
                                 bool with_error_map) {
  std::vector<Origin> origins = origins_in(cell, calibration_files(cell, with_error_map));
  origins.push_back(origin_of({Role::kDrawing, drawing}));
  return origins;
}

std::shared_ptr<const LaidWorks> read_works(const fs::path& path, const CalibratedCell& cell,
                                            bool accepts_stale) {
  auto works = std::make_shared<const LaidWorks>(read_works(path));
  require_made_with(
      {Role::kWork, path},
      origins_in(cell.settings, calibration_files(cell.settings, uses_error_map(cell))),
      accepts_stale);
  const bool had_map = find_role(read_origins(path), Role::kErrorMap) != nullptr;
  if (had_map != uses_error_map(cell))
    accept_stale({StaleFile{{had_map ? "was found with the error map, which is not used now"
                                     : "was found without the error map, which is used now",
                             "find it again as it is to be used", path, Cause::kForeign},
                            path}},
                 accepts_stale);
  return works;
}

std::vector<TargetRow> on_works(const std::vector<TargetRow>& drawn,
                                const std::vector<FoundWork>& works) {
  std::vector<TargetRow> targets;
  for (const FoundWork& work : works)
    for (TargetRow target : drawn) {
      if (works.size() > 1) target.id = work.id + "/" + target.id;
      target.sigma_m = per_axis(work.pose.covariance_at(target.p_d));
      target.p_d = work.pose.in_base(target.p_d);
      if (target.phi_d) target.phi_d = *target.phi_d + work.pose.turn();
      targets.push_back(std::move(target));
    }
  return targets;
}

Path on_work(const Path& drawn, const WorkPose& work) {
  std::vector<Waypoint> waypoints = drawn.waypoints();
  for (Waypoint& waypoint : waypoints) {
    if (waypoint.via && work.map == WorkMap::kAffine)
      throw InputError(
          Refusal{"an arc becomes part of an ellipse on a work that is stretched to one side",
                  "draw it by short lines, or find the work with --map similarity"});
    waypoint.pose = {work.in_base(waypoint.pose.p), waypoint.pose.phi + work.turn()};
    if (waypoint.via) waypoint.via = work.in_base(*waypoint.via);
  }
  return Path(waypoints);
}

}  // namespace planar
