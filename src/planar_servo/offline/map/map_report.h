#pragma once

#include <Eigen/Core>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "planar_servo/learn/error_map/compare_methods.h"
#include "planar_servo/learn/error_map/error_sample.h"
#include "planar_servo/learn/field/fit_lamp_field.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Lists what a fit found, the faults of the cell, and how the methods compare.
ReportList map_fit_list(const FitErrorMapReport& report,
                        const std::vector<MethodFigures>& comparison);

/// Lists what a fit of field and arm found, what fixed it and how places left out are met.
ReportList lamp_field_list(const LampFieldFit& fit);

/// The content of a page about any map. Lengths are in metres.
struct MapView {
  Verdict verdict;
  std::vector<Eigen::Vector2d> places;  ///< end points as vision saw them
  std::vector<Eigen::Vector2d> raw,
      left;                             ///< errors there, and what is left where each is left out
  std::vector<double> pulls;            ///< of `left` per axis; empty where none is stated
  std::vector<ComparedField> compared;  ///< ways to predict the error, where some were compared
  ValidRegion region;
  /// The error that the map predicts for an end point.
  std::function<ErrorPrediction(const Eigen::Vector2d&)> predict;
  std::string what_is_drawn;  ///< says for which tool the field is drawn; a sentence
  ReportList list;            ///< what the program found
};

/// Say by the program's own figures whether a map is good.
Verdict map_verdict(const FitErrorMapReport& report);
Verdict map_verdict(const LampFieldFit& fit);

/// Return what the page shows of a map at the end point, and of a field at the lamps, drawn for a
/// tool that points along the base's x axis. The view refers to its argument.
MapView view_of(const FitErrorMapReport& report, const ReportList& list);
MapView view_of(const LampFieldFit& fit, const ReportList& list);

std::string map_page(const MapView& view, const std::filesystem::path& file);

}  // namespace planar
