#include "planar_servo/experiment/figures/report_figure.h"

#include <fmt/format.h>

namespace planar {

ReportFigure paper_figure(int number, const std::string& what, const std::string& caption,
                          const std::string& svg) {
  return {fmt::format("figure_{:02}.svg", number), fmt::format("Figure {}: {}", number, what),
          caption, svg};
}

}  // namespace planar
