#pragma once

#include <string>

namespace planar {

/// A figure of the report, which is a file of its own as well.
struct ReportFigure {
  std::string file;  ///< the file's name
  std::string title;
  std::string caption;  ///< what it shows, on what data, and what to look at
  std::string svg;
};

/// Returns a figure of the paper, named by its number there.
ReportFigure paper_figure(int number, const std::string& what, const std::string& caption,
                          const std::string& svg);

}  // namespace planar
