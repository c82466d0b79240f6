#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/text.h"

namespace planar::python {

namespace py = pybind11;

/// Finite numbers of an argument: one row per thing, where the argument has (N, columns), or one
/// row, where it has (columns,), for a single thing.
struct Rows {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;
  bool is_single{false};

  py::ssize_t count() const { return values.rows(); }
};

/// Reads an array of floats or whole numbers, of any order in memory, or what NumPy makes one of.
/// Throws InputError with the argument's name and the allowed shape for another shape or type, and
/// for numbers that are not finite.
Rows rows_of(const char* argument, const py::object& value, Eigen::Index columns);
/// Reads one thing: an array of `size` numbers.
Eigen::VectorXd vector_of(const char* argument, const py::object& value, Eigen::Index size);
/// Reads (N,) numbers, or one number for all N things.
Eigen::VectorXd numbers_of(const char* argument, const py::object& value, Eigen::Index count);
/// Reads (N,) numbers that need not be finite.
std::vector<double> column_of(const char* argument, const py::object& value);
/// Reads (N,) texts; whole numbers become texts. Throws InputError for each that is neither.
std::vector<std::string> texts_of(const char* argument, const py::object& value);
/// Reads a matrix of this size.
Eigen::MatrixXd matrix_of(const char* argument, const py::object& value, Eigen::Index rows,
                          Eigen::Index columns);

/// Checks lengths. Throws InputError for one that no arm has, as of millimetres.
void require_metres(const char* argument, const Eigen::Ref<const Eigen::MatrixXd>& lengths);

/// Checks directions. Throws InputError for one of more turns than a tool makes, as of degrees.
void require_radians(const char* argument, const Eigen::Ref<const Eigen::MatrixXd>& angles);

/// Reads (N, 2) numbers as points.
std::vector<Eigen::Vector2d> points_of(const char* argument, const py::object& value);

/// Returns a grey picture that shares the memory of the argument, which must outlive it. Throws
/// InputError unless that is a uint8 array (rows, columns) with the pixels of a row side by side.
cv::Mat image_of(const char* argument, const py::object& value);

/// Returns the name of an argument's type.
std::string type_name(const py::object& value);

/// Checks one number. Throws InputError unless it is finite.
double finite(const char* argument, double value);

/// The result for N things: an array (N, shape...), whose only entry is returned for a single one.
class Results {
 public:
  Results(const Rows& rows, std::initializer_list<py::ssize_t> shape);

  /// Returns where the numbers of thing i begin.
  double* at(py::ssize_t i) { return data_ + i * size_; }
  /// Fills thing i with NaN: it has no value.
  void clear(py::ssize_t i);
  template <typename Matrix>
  void set(py::ssize_t i, const Matrix& values) {
    double* out = at(i);
    for (Eigen::Index r = 0; r < values.rows(); ++r)
      for (Eigen::Index c = 0; c < values.cols(); ++c) *out++ = values(r, c);
  }
  py::object result() const;

 private:
  py::array_t<double> array_;
  double* data_;
  py::ssize_t size_;
  bool is_single_;
};

/// Returns an array with the numbers of a matrix or vector.
template <typename Matrix>
py::array_t<double> array_from(const Matrix& matrix) {
  if constexpr (Matrix::ColsAtCompileTime == 1) {
    py::array_t<double> array(matrix.rows());
    for (Eigen::Index r = 0; r < matrix.rows(); ++r) array.mutable_at(r) = matrix(r);
    return array;
  } else {
    py::array_t<double> array({matrix.rows(), matrix.cols()});
    for (Eigen::Index r = 0; r < matrix.rows(); ++r)
      for (Eigen::Index c = 0; c < matrix.cols(); ++c) array.mutable_at(r, c) = matrix(r, c);
    return array;
  }
}

/// Returns a point as text, its coordinates with so many decimals.
std::string point_text(const Eigen::Vector2d& p, int decimals);

/// Returns from where to where points lie, as text in metres.
std::string extent_text(const std::vector<Eigen::Vector2d>& points);

/// Returns points as an array (N, 2).
py::array_t<double> array_from(const std::vector<Eigen::Vector2d>& points);

/// Returns the value that stands for a word. Throws InputError naming those that are allowed.
template <typename Enum, std::size_t kSize>
Enum value_of(const char* argument, const std::string& word, const Named<Enum> (&table)[kSize]);

[[noreturn]] void refuse_word(const char* argument, const std::string& word,
                              const std::vector<std::string>& allowed);

template <typename Enum, std::size_t kSize>
Enum value_of(const char* argument, const std::string& word, const Named<Enum> (&table)[kSize]) {
  if (const auto value = value_named(table, word)) return *value;
  refuse_word(argument, word, names_of(table));
}

}  // namespace planar::python
