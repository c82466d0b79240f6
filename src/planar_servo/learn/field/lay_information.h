#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/learn/field/field_basis.h"

namespace planar {

/// The dots of a board that was laid on the plane, as one picture shows them, metres.
struct BoardLay {
  std::string id;
  /// On the board seen from above, turned and shifted; in any unit if the pitch is not known.
  Eigen::Matrix2Xd p_board;
  Eigen::Matrix2Xd seen_B;  ///< base frame
  Eigen::VectorXd sigma;    ///< of seen_B, per axis
};

/// The two marks of a bar, where a picture shows them: base frame, uncompensated, metres.
struct LengthSight {
  std::array<Eigen::Vector2d, 2> seen_B;
  double sigma{0.0};  ///< of their seen distance
};

/// A mark of the base, where it is known to be and where a picture shows it.
struct MarkSight {
  Eigen::Vector2d p_B{0.0, 0.0}, seen_B{0.0, 0.0};
  double sigma{0.0};  ///< of both together, per axis
};

/// What lies on the plane: lays of one board, a certified bar in several places, marks of the base.
struct LaidDots {
  std::vector<BoardLay> lays;
  bool pitch_known{true};
  std::vector<LengthSight> lengths{};
  double length{0.0}, length_sigma{0.0};  ///< of the bar, the deviation common to all its sights
  std::vector<MarkSight> marks{};
  /// Of the shift, per axis, that lamps at the edge of the field have beside marks and bar by their
  /// rims and glow; half of its variance grows with the distance from the camera's foot. Metres.
  double lamps_shift_sigma{0.0};
  Eigen::Vector2d foot_B{0.0, 0.0};  ///< of the camera

  std::size_t dots() const;
};

/// What these tell of a field without drift: but for a constant, -2 log likelihood of its
/// weights w (those of x, then of y) is squares - 2 right . w + w . H w + log_determinant.
struct LayInformation {
  Eigen::MatrixXd H;
  Eigen::VectorXd right;
  double squares{0.0};
  double log_determinant{0.0};
};

/// Returns what is told by what lies on the disc of `basis`, seen place = place + field. A bar
/// tells of the field along it; its place and turn are free. Nothing is known of the board but that
/// it is flat and its dots form the pattern: the place and turn of each lay are free, and so are,
/// within what printers do, the pattern's aspect and shear, which all lays share; without a known
/// pitch its scale is free, too. `factor` multiplies the dots' deviations.
LayInformation lay_information(const LaidDots& laid, const FieldBasis& basis, double factor);

/// Says why these lays cannot tell the field's shape by themselves; empty when they can. Lays that
/// are only shifted cannot tell a board whose rows are not square from a field that stretches.
std::optional<Refusal> doubt_of_turns(const LaidDots& board);

}  // namespace planar
