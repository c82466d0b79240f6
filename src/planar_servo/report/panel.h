#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/report/axis.h"

namespace planar {

/// Colours of series that are told apart in one panel [Okabe and Ito 2008, darkened for thin
/// lines]. A series' colour brings the shape of its marks and the dashes of its lines, which tell
/// it from the others without colour.
constexpr const char* kSeriesColors[] = {"#1f4e79", "#c77f1a", "#2e8b57", "#a23b72", "#666666"};

/// The scale of arrows. Panels that share one can be compared by the arrows' lengths.
struct ArrowScale {
  double longest{0.0};  ///< what is drawn kLongestArrow long, in the unit of the vectors
  std::string unit;     ///< for the legend
};

constexpr double kLongestArrow = 34.0;  ///< SVG units

/// Returns the scale at which the longest vector is drawn kLongestArrow long.
ArrowScale arrows_over(const std::vector<Eigen::Vector2d>& vectors, const std::string& unit);

/// Colours of marks: one for all, or a value on a scale for each.
struct Paint {
  std::string color{"#1f4e79"};
  const ColorScale* scale{nullptr};
  std::vector<double> values{};  ///< as many as marks where there is a scale

  std::string of(std::size_t i) const { return scale ? scale->color(values[i]) : color; }
};

/// One panel of a plot: axes with ticks, a title, and marks in the units of the axes. What is added
/// later lies on top. Beyond kMostMarks marks only every n-th is drawn, and the panel says so.
class Panel {
 public:
  enum class Aspect {
    kFree,   ///< as wide as kPanelWidth and as high as kPanelHeight
    kEqual,  ///< a unit is as long along both axes
  };

  Panel(std::string title, Axis x, Axis y, Aspect aspect = Aspect::kFree);
  Panel(std::string title, const FieldAxes& axes)
      : Panel(std::move(title), axes.x, axes.y, Aspect::kEqual) {}

  /// Returns the places at which add_field() wants a value: kFieldCells along each axis.
  std::vector<Eigen::Vector2d> field_places() const;
  /// Fills the panel with the colours of a value at each of field_places(); where it is NaN, the
  /// panel stays empty. Throws std::invalid_argument unless there are as many values.
  void add_field(const std::vector<double>& values, const ColorScale& scale);

  /// Draws arrows in the axes' directions. Throws std::invalid_argument unless there are as many
  /// points as vectors.
  void add_arrows(const std::vector<Eigen::Vector2d>& points,
                  const std::vector<Eigen::Vector2d>& vectors, const ArrowScale& scale,
                  const Paint& paint = {});
  void add_dots(const std::vector<Eigen::Vector2d>& points, const Paint& paint = {},
                double radius = 2.2);
  enum class Stroke { kSolid, kDashed };
  void add_line(const std::vector<Eigen::Vector2d>& points, Stroke stroke = Stroke::kSolid,
                const std::string& color = "#222");
  /// Draws bars from zero, from one edge to the next: one more edge than heights.
  void add_bars(const std::vector<double>& edges, const std::vector<double>& heights);
  void add_color_bar(const ColorScale& scale);
  /// Writes a line below the panel, as a legend.
  void add_note(const std::string& note);
  enum class Sample { kMark, kLine };
  struct Key {
    std::string color, what;
    Sample sample{Sample::kMark};
  };
  /// Writes several keys into one line of the legend, evenly spaced.
  void add_keys(const std::vector<Key>& keys);
  /// Says in the legend what the marks of a colour, or its lines, are.
  void add_key(const std::string& color, const std::string& what, Sample sample = Sample::kMark) {
    add_keys({{color, what, sample}});
  }

  const std::string& title() const { return title_; }
  /// Returns what a reader who cannot see the panel must know: axes and legend, as sentences.
  std::string description() const;
  /// Draws the panel, its outer upper left corner at (left, 0).
  std::string svg(double left) const;
  double width() const;
  double height() const;

 private:
  Eigen::Vector2d at(const Eigen::Vector2d& p) const;
  /// Returns ticks along x whose numbers do not touch.
  Ticks ticks_along_x() const;
  std::string axes() const;
  std::size_t stride(std::size_t marks);

  std::string title_;
  Axis x_, y_;
  double plot_width_, plot_height_;
  std::string marks_;
  std::string bar_;
  std::vector<std::string> legend_;  ///< lines of SVG at (0, 0)
  std::vector<std::string> words_;   ///< the legend without its samples
};

constexpr double kPanelWidth = 290.0;
constexpr double kPanelHeight = 290.0;
constexpr std::size_t kMostMarks = 2500;
/// Columns and rows of colours in a field.
constexpr int kFieldCells = 48;

}  // namespace planar
