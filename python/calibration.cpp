#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/pairs/pair_files.h"
#include "planar_servo/offline/pairs/pair_tracker.h"

namespace planar::python {
namespace {

namespace fs = std::filesystem;

DatumRegistration register_readings(const std::vector<std::string>& ids, const py::object& p_known,
                                    const std::vector<std::string>& read_ids,
                                    const py::object& p_read, double sigma) {
  const Rows known = rows_of("p_known", p_known, 3), read = rows_of("p_read", p_read, 3);
  require_metres("p_known", known.values);
  const auto check = [](const char* argument, std::size_t size, py::ssize_t count) {
    if (size != static_cast<std::size_t>(count))
      throw InputError({"has " + std::to_string(size) + " ids",
                        "one for each row is needed: " + std::to_string(count), argument});
  };
  check("ids", ids.size(), known.count());
  check("read_ids", read_ids.size(), read.count());
  if (!(finite("sigma", sigma) >= 0.0))
    throw InputError({"is negative", "metres, or 0 where it is not known", "sigma"});
  std::vector<Monument> monuments;
  for (std::size_t i = 0; i < ids.size(); ++i)
    monuments.push_back({ids[i], known.values.row(static_cast<Eigen::Index>(i)).transpose()});
  std::vector<MonumentReading> readings;
  for (std::size_t i = 0; i < read_ids.size(); ++i)
    readings.push_back(
        {read_ids[i], read.values.row(static_cast<Eigen::Index>(i)).transpose(), sigma});
  const py::gil_scoped_release release;
  return register_datum(monuments, readings);
}

py::list residuals_of(const DatumRegistration& datum) {
  py::list residuals;
  for (const MonumentResidual& monument : datum.residuals)
    residuals.append(
        py::make_tuple(monument.id, monument.readings, array_from(monument.residual_B)));
  return residuals;
}

PairTrackerReport pair(const fs::path& cell, const fs::path& lamps, const fs::path& recording,
                       const std::string& by, const std::optional<fs::path>& tracker,
                       bool accept_step, const std::optional<fs::path>& pairs_out,
                       const std::optional<fs::path>& workplane_out,
                       const std::optional<fs::path>& tool_out) {
  if (by != "id" && by != "time") refuse_word("by", by, {"id", "time"});
  const int outputs = pairs_out.has_value() + workplane_out.has_value() + tool_out.has_value();
  if (outputs != 0 && outputs != 3)
    throw InputError({"pairs_out, workplane_out and tool_out belong together",
                      "name all three, or none", "pairs_out"});
  const py::gil_scoped_release release;
  PairTrackerRequest request;
  request.cell = read_cell(cell);
  request.camera = read_cell_camera(request.cell);
  request.lamps = read_lamps(lamps);
  request.frames = read_frames(recording);
  const RecordedTables tables{lamps, recording / "frames.csv",
                              tracker.value_or(recording / "tracker.csv")};
  const PairFiles files{workplane_out.value_or(""), tool_out.value_or(""), pairs_out.value_or("")};
  require_outputs({{files.workplane, "workplane"}, {files.tool, "tool"}, {files.pairs, "pairs"}},
                  {cell, request.cell.camera_model, tables.lamps, tables.frames, tables.tracker});
  require_belonging(stale_tables(request.cell, tables));
  request.tracker = read_tracker(tables.tracker);
  request.by = by == "time" ? PairBy::kTime : PairBy::kId;
  request.accept_step = accept_step;
  PairTrackerReport report = pair_tracker(request);
  if (outputs == 3)
    write_pair_files(files, request.cell, tables, report.workplane, WorkplaneSource::kPairs,
                     report.pairs, "planar_servo");
  return report;
}

py::list rejected_of(const PairTrackerReport& report) {
  py::list rejected;
  for (const Rejection& rejection : report.rejected)
    rejected.append(py::make_tuple(rejection.id, rejection.reason));
  return rejected;
}

/// Returns a point of each attended pair.
template <typename Point>
py::array_t<double> points_from(const PairTrackerReport& report, const Point& point) {
  std::vector<Eigen::Vector2d> points;
  for (const PairRow& row : report.pairs)
    if (row.is_attended()) points.push_back(point(row));
  return array_from(points);
}

void bind_boards(py::module_& m) {
  py::class_<BoardSight>(m, "BoardSight", "What a picture shows of a board.")
      .def_property_readonly("found", &BoardSight::found)
      .def_property_readonly(
          "pixels", [](const BoardSight& s) { return array_from(s.pixels); },
          "(N, 2): dots or corners, row by row; empty when it was not found.")
      .def_readonly("dot_areas_px2", &BoardSight::dot_areas_px2)
      .def_readonly("dot_sigmas_px", &BoardSight::dot_sigmas_px)
      .def_readonly("reason", &BoardSight::reason, "Why it was not found.")
      .def("__repr__", [](const BoardSight& s) {
        return s.found() ? fmt::format("<BoardSight: {} points>", s.pixels.size())
                         : fmt::format("<BoardSight: not found, {}>", s.reason);
      });
  m.def(
      "find_board",
      [](const py::object& image, const std::string& board) {
        const cv::Mat picture = image_of("image", image);
        const Board wanted = parse_board(board, BoardUse::kShape);
        const py::gil_scoped_release release;
        return find_board(picture, wanted);
      },
      py::arg("image"), py::arg("board"),
      "Finds a board such as 'circles:11x11:50mm' or 'chessboard:9x6:25mm' in a uint8 picture.");
  m.def(
      "board_points",
      [](const std::string& board) { return array_from(board_points(parse_board(board))); },
      py::arg("board"), "Returns the board's points (N, 2), metres, in the order of find_board().");
}

}  // namespace

void bind_calibration(py::module_& m) {
  bind_boards(m);
  py::class_<DatumRegistration>(m, "Registration", "A tracker tied to the base by its monuments.")
      .def_property_readonly(
          "X_BL",
          [](const DatumRegistration& d) { return array_from(Eigen::Matrix4d(d.X_BL.matrix())); },
          "(4, 4): p_B = X_BL p_L, metres.")
      .def_readonly("rms", &DatumRegistration::rms, "Of the residuals' lengths, metres.")
      .def_property_readonly("residuals", &residuals_of,
                             "List of (id, readings, mean reading minus known (3,), metres).")
      .def_readonly("left_out", &DatumRegistration::left_out, "The monument that moved, or None.")
      .def_property_readonly(
          "doubt", [](const DatumRegistration& d) { return d.doubt.text(); },
          "What noise does not explain; empty when it explains all.")
      .def("__repr__", [](const DatumRegistration& d) {
        return fmt::format("<Registration: {} monuments, rms {:.4f} mm>", d.residuals.size(),
                           mm(d.rms));
      });
  m.def(
      "register_tracker", &register_readings, py::arg("ids"), py::arg("p_known"),
      py::arg("read_ids"), py::arg("p_read"), py::arg("sigma") = 0.0,
      "Ties a tracker to the base by the rigid motion that fits best [Kabsch 1976; Umeyama 1991]:\n"
      "monuments ids with known places (N, 3), base frame, and\n"
      "readings (M, 3), tracker's frame, of the monuments read_ids; metres. sigma is that of a\n"
      "reading per axis, 0 where it is not known. Raises InputError where the readings contradict\n"
      "the places.");
  py::class_<PairTrackerReport>(m, "Pairing", "Lamps paired with tracker readings.")
      .def_property_readonly(
          "p_vision",
          [](const PairTrackerReport& r) {
            return points_from(r, [](const PairRow& row) { return row.p_vision; });
          },
          "(N, 2): end points as vision saw them, base frame, metres.")
      .def_property_readonly(
          "p_tracker",
          [](const PairTrackerReport& r) {
            return points_from(r, [](const PairRow& row) { return *row.p_tracker; });
          },
          "(N, 2): the same by the tracker.")
      .def_property_readonly("ids",
                             [](const PairTrackerReport& r) {
                               std::vector<std::string> ids;
                               for (const PairRow& row : r.pairs)
                                 if (row.is_attended()) ids.push_back(row.id);
                               return ids;
                             })
      .def_property_readonly("rejected", &rejected_of, "List of (id, reason).")
      .def_readonly("registration", &PairTrackerReport::datum, "None without a tracker.")
      .def_property_readonly(
          "X_WC",
          [](const PairTrackerReport& r) {
            return array_from(Eigen::Matrix4d(r.workplane.X_WC.matrix()));
          },
          "(4, 4): the camera over the plane of the lamps, metres.")
      .def_property_readonly("workplane_rms",
                             [](const PairTrackerReport& r) { return r.workplane.rms; })
      .def_property_readonly(
          "p_TP", [](const PairTrackerReport& r) { return array_from(r.workplane.tool.p_TP); },
          "(2,): the end point in the lamps' frame, metres.")
      .def_property_readonly(
          "doubts",
          [](const PairTrackerReport& r) {
            std::vector<std::string> doubts;
            for (const Refusal& doubt : r.doubts) doubts.push_back(doubt.text());
            return doubts;
          },
          "What the readings leave open, and what to do.")
      .def("__repr__", [](const PairTrackerReport& r) {
        return fmt::format("<Pairing: {} pairs, {} rejected, {} doubts>", r.pairs.size(),
                           r.rejected.size(), r.doubts.size());
      });
  m.def(
      "pair_tracker", &pair, py::arg("cell"), py::arg("lamps"), py::arg("recording"), py::kw_only(),
      py::arg("by") = "id", py::arg("tracker") = py::none(), py::arg("accept_step") = false,
      py::arg("pairs_out") = py::none(), py::arg("workplane_out") = py::none(),
      py::arg("tool_out") = py::none(),
      "Pairs lamps.csv of a recording with a table of readings, its tracker.csv where none is\n"
      "named, by 'id' or 'time', and fits workplane and tool, as planar-pair-tracker does.\n"
      "accept_step pairs although something seems to have moved between readings. The three files\n"
      "are written where they are named.");
}

}  // namespace planar::python
