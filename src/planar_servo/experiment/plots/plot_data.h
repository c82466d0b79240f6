#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/lamps/paper_center.h"
#include "planar_servo/learn/error_map/error_map.h"
#include "planar_servo/offline/plan/experiment_plan.h"

namespace planar {

/// A lamp as the paper's chain measures it in one recorded image, pixels of the whole sensor.
struct LampEdges {
  std::string image;    ///< its name in the recording
  cv::Mat grey;         ///< the part of the image about the lamp, CV_8UC1
  cv::Point origin_px;  ///< of that part
  std::vector<Eigen::Vector2d> edges_px;
  Circle circle;  ///< fitted to them
};

/// A place on a circle that is gone round several times. End points in the base frame, metres.
struct CirclePlace {
  int radius_mm{0};
  int run{0};    ///< from 1
  int index{0};  ///< number along the circle, from 0
  Eigen::Vector2d p_plan{0.0, 0.0}, p_vision{0.0, 0.0}, p_tracker{0.0, 0.0};

  Eigen::Vector2d seen_beside_plan() const { return p_vision - p_plan; }
  Eigen::Vector2d read_beside_plan() const { return p_tracker - p_plan; }
  Eigen::Vector2d vision_error() const { return p_vision - p_tracker; }
};

/// A place on a circle that checks the maps: the vision error there and what two maps predict.
struct PredictedPlace {
  int radius_mm{0};
  int index{0};  ///< number along the circle, from 0
  Eigen::Vector2d p_vision{0.0, 0.0};
  Eigen::Vector2d measured{0.0, 0.0}, by_idw{0.0, 0.0}, by_rbf{0.0, 0.0};
};

/// Records of the paper's chain for the paper's figures. Errors are vision minus tracker, metres,
/// before any map.
struct PlotData {
  std::vector<LampEdges> lamps;  ///< both lamps at one place; none when its image is gone
  std::vector<CirclePlace> circles;
  std::vector<PairRow> training;  ///< to which the maps were fitted
  std::vector<PredictedPlace> checks;
  ErrorMap idw, rbf;
};

/// Collects the data from the paper's chain and the recording that it was calibrated from.
PlotData plot_data(const CalibratedChain& paper, const ExperimentPlan& plan,
                   const RecordedCell& recording);

}  // namespace planar
