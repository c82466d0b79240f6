#include "planar_servo/files/tables/grid_exports.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "planar_servo/base/core/units.h"
#include "planar_servo/files/tables/table_columns.h"

namespace planar {
namespace {

constexpr char kSeen[] = "places as seen; compensated = seen - error";
constexpr char kTrue[] = "compensated places; seen = compensated + error";

std::string format_line() {
  return fmt::format("format: planar-servo/{}/1", kErrorGridKind);
}

/// Appends the bytes of a number, on a machine whose least byte comes first.
template <typename Number>
void append(std::string& bytes, Number number) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &number, sizeof(Number));
  bytes.append(raw, sizeof(Number));
}

/// Returns the format and the remarks in one line that may stand between quotes of any language.
std::string in_one_line(const std::vector<std::string>& remarks) {
  std::string line = format_line();
  for (const std::string& remark : remarks) line += "; " + remark.substr(2);
  for (char& c : line)
    if (c < ' ' || c > '~' || c == '\'' || c == '"' || c == '\\') c = '_';
  return line;
}

/// Returns the first bytes of a .npy file, version 1.0, padded so that its data begins at a
/// multiple of 64. The title of the first field is the only place for remarks.
std::string numpy_head(const ErrorGrid& grid, const std::vector<std::string>& remarks) {
  constexpr std::size_t kBeforeText = 10, kAlignment = 64;
  std::string text = fmt::format(
      "{{'descr': [(('{}', 'x_mm'), '<f8'), ('y_mm', '<f8'), ('dx_mm', '<f8'), ('dy_mm', '<f8'), "
      "('sigma_mm', '<f8'), ('valid', '|b1')], 'fortran_order': False, 'shape': ({}, {}), }}",
      in_one_line(remarks), grid.rows, grid.columns);
  text.append(kAlignment - (kBeforeText + text.size() + 1) % kAlignment, ' ');
  std::string head("\x93NUMPY\x01\x00", 8);
  append(head, static_cast<std::uint16_t>(text.size() + 1));
  return head + text + "\n";
}

std::string numpy_text(const ErrorGrid& grid, const std::vector<std::string>& remarks) {
  std::string text = numpy_head(grid, remarks);
  for (Eigen::Index i = 0; i < grid.nodes(); ++i) {
    const Eigen::Vector2d p = grid.node(i);
    for (const double length : {p.x(), p.y(), grid.errors(0, i), grid.errors(1, i), grid.sigmas[i]})
      append(text, mm(length));
    append(text, grid.inside[i]);
  }
  return text;
}

/// Returns what cv::FileStorage reads. A pixel (u, v) of both pictures is the place origin + step
/// (u, v): dst shows at the true place what src shows where it is seen.
std::string remap_text(const ErrorGrid& grid, const std::vector<std::string>& remarks) {
  const cv::Size size(static_cast<int>(grid.columns), static_cast<int>(grid.rows));
  cv::Mat map(size, CV_32FC2), sigma(size, CV_32FC1), valid(size, CV_8UC1);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Index i = v * grid.columns + u;
      const Eigen::Vector2d seen = Eigen::Vector2d(u, v) + grid.errors.col(i) / grid.step;
      map.at<cv::Vec2f>(v, u) =
          cv::Vec2f(static_cast<float>(seen.x()), static_cast<float>(seen.y()));
      sigma.at<float>(v, u) = static_cast<float>(mm(grid.sigmas[i]));
      valid.at<unsigned char>(v, u) = grid.inside[i] ? 255 : 0;
    }
  }
  cv::FileStorage file(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "x0_mm" << mm(grid.origin.x()) << "y0_mm" << mm(grid.origin.y());
  file << "step_mm" << mm(grid.step) << "map" << map << "sigma_mm" << sigma << "valid" << valid;
  const std::string begin = "---\n";
  std::string text = file.releaseAndGetString();
  return text.insert(text.find(begin) + begin.size(),
                     fmt::format("# {}\n{}\n", format_line(), fmt::join(remarks, "\n")));
}

}  // namespace

const TableSchema<ErrorGridRow>& error_grid_schema() {
  static constexpr Named<bool> kValid[] = {{true, "1"}, {false, "0"}};
  static const TableSchema<ErrorGridRow> grids{
      kErrorGridKind, [](Columns& columns, ErrorGridRow& row) {
        columns.point("x_mm", "y_mm", row.p, kMillimetre, 6);
        columns.point("dx_mm", "dy_mm", row.error, kMillimetre, 7);
        columns.optional_number("sigma_mm", row.sigma, kMillimetre, 7);
        columns.check(row.sigma.value_or(0.0) >= 0.0,
                      {"sigma_mm is negative", "a standard deviation is needed"}, "sigma_mm");
        columns.choice("valid", row.valid, kValid);
      }};
  return grids;
}

std::string error_grid_text(const ErrorGrid& grid, const std::vector<std::string>& remarks) {
  std::string text = error_grid_schema().header(remarks);
  for (Eigen::Index i = 0; i < grid.nodes(); ++i) {
    const double sigma = grid.sigmas[i];
    text += error_grid_schema().line({grid.node(i), grid.errors.col(i),
                                      std::isfinite(sigma) ? std::optional(sigma) : std::nullopt,
                                      grid.inside[i]});
  }
  return text;
}

TableForm error_grid_form() {
  return form_of(error_grid_schema());
}

GridUse use_of(GridFormat format) {
  switch (format) {
    case GridFormat::kCsv:
      return {false, kSeen, "planar-fit-error-map -o map.yaml FILE"};
    case GridFormat::kNumpy:
      return {false, kSeen, "numpy.load('FILE')"};
    case GridFormat::kOpencvRemap:
      return {true, kTrue, "cv::remap(seen, compensated, map, cv::noArray(), cv::INTER_LINEAR)"};
  }
  throw std::invalid_argument("no such format of a grid");
}

std::string grid_text(GridFormat format, const ErrorGrid& grid,
                      const std::vector<std::string>& remarks) {
  switch (format) {
    case GridFormat::kCsv:
      return error_grid_text(grid, remarks);
    case GridFormat::kNumpy:
      return numpy_text(grid, remarks);
    case GridFormat::kOpencvRemap:
      return remap_text(grid, remarks);
  }
  throw std::invalid_argument("no such format of a grid");
}

}  // namespace planar
