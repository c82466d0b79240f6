#include "arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/error.h"

namespace planar::python {
namespace {

std::string shape_text(const py::array& array) {
  std::string text;
  for (py::ssize_t axis = 0; axis < array.ndim(); ++axis)
    text += fmt::format("{}{}", axis == 0 ? "" : ", ", array.shape(axis));
  return fmt::format("({}{})", text, array.ndim() == 1 ? "," : "");
}

std::string described(const py::array& array) {
  return fmt::format("is an array of {} of shape {}", std::string(py::str(array.dtype())),
                     shape_text(array));
}

/// Nothing that follows knows a mask. Throws InputError for an array that hides some of its values.
void require_unmasked(const char* argument, const py::object& value) {
  if (py::hasattr(value, "mask") &&
      py::module_::import("numpy.ma").attr("is_masked")(value).cast<bool>())
    throw InputError({"is an array with masked values",
                      "give them values (.filled()), or leave out what they belong to", argument});
}

/// Returns the argument as an array; `allowed` says what is.
py::array array_of(const char* argument, const py::object& value, const std::string& allowed) {
  require_unmasked(argument, value);
  py::array array = py::array::ensure(value);
  if (array) return array;
  PyErr_Clear();
  throw InputError({"is of type " + type_name(value), allowed, argument});
}

/// Returns the argument as an array of doubles side by side: py::array_t::at() divides strides by a
/// double's size, which a field of a table need not be a multiple of.
py::array_t<double> doubles_of(const char* argument, const py::object& value,
                               const std::string& allowed) {
  const py::array array = array_of(argument, value, allowed);
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw InputError({described(array), allowed, argument});
  constexpr int kAligned = py::detail::npy_api::NPY_ARRAY_ALIGNED_;
  auto doubles =
      py::array_t<double, py::array::forcecast | py::array::c_style | kAligned>::ensure(array);
  if (doubles) return doubles;
  PyErr_Clear();
  throw InputError({described(array), allowed, argument});
}

/// Returns a text, or a whole number as one; nothing for what is neither.
std::optional<std::string> text_of(const py::handle& value) {
  const bool is_whole = PyLong_Check(value.ptr()) && !PyBool_Check(value.ptr());
  if (!is_whole && !py::isinstance<py::str>(value)) return std::nullopt;
  py::detail::make_caster<std::string> text;
  if (!text.load(py::str(value), false)) return std::nullopt;  // half a character
  return py::detail::cast_op<std::string>(text);
}

void require_finite(const char* argument, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  for (Eigen::Index r = 0; r < values.rows(); ++r)
    for (Eigen::Index c = 0; c < values.cols(); ++c)
      if (!std::isfinite(values(r, c)))
        throw InputError(
            {fmt::format("has {} in row {}, column {} (both from 0)", values(r, c), r, c),
             "finite numbers are needed", argument});
}

}  // namespace

Rows rows_of(const char* argument, const py::object& value, Eigen::Index columns) {
  const std::string allowed =
      fmt::format("numbers of shape (N, {}), or ({},) for one, are needed", columns, columns);
  const py::array_t<double> array = doubles_of(argument, value, allowed);
  const py::ssize_t dimensions = array.ndim();
  if ((dimensions != 1 && dimensions != 2) || array.shape(dimensions - 1) != columns)
    throw InputError({described(array), allowed, argument});
  Rows rows;
  rows.is_single = dimensions == 1;
  rows.values.resize(rows.is_single ? 1 : array.shape(0), columns);
  for (Eigen::Index r = 0; r < rows.values.rows(); ++r)
    for (Eigen::Index c = 0; c < columns; ++c)
      rows.values(r, c) = rows.is_single ? array.at(c) : array.at(r, c);
  require_finite(argument, rows.values);
  return rows;
}

Eigen::VectorXd vector_of(const char* argument, const py::object& value, Eigen::Index size) {
  const std::string allowed = fmt::format("numbers of shape ({},) are needed", size);
  const py::array_t<double> array = doubles_of(argument, value, allowed);
  if (array.ndim() != 1 || array.shape(0) != size)
    throw InputError({described(array), allowed, argument});
  Eigen::VectorXd values(size);
  for (Eigen::Index i = 0; i < size; ++i) values[i] = array.at(i);
  require_finite(argument, values);
  return values;
}

Eigen::VectorXd numbers_of(const char* argument, const py::object& value, Eigen::Index count) {
  const std::string allowed = fmt::format("a number, or numbers of shape ({},), are needed", count);
  const py::array_t<double> array = doubles_of(argument, value, allowed);
  if (array.ndim() > 1 || (array.ndim() == 1 && array.shape(0) != count))
    throw InputError({described(array), allowed, argument});
  Eigen::VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i)
    values[i] = array.ndim() == 0 ? *array.data() : array.at(i);
  require_finite(argument, values);
  return values;
}

std::vector<double> column_of(const char* argument, const py::object& value) {
  const std::string allowed = "numbers of shape (N,) are needed, NaN where there is none";
  const py::array_t<double> array = doubles_of(argument, value, allowed);
  if (array.ndim() != 1) throw InputError({described(array), allowed, argument});
  std::vector<double> numbers;
  numbers.reserve(static_cast<std::size_t>(array.size()));
  for (py::ssize_t i = 0; i < array.size(); ++i) numbers.push_back(array.at(i));
  return numbers;
}

std::vector<std::string> texts_of(const char* argument, const py::object& value) {
  const std::string allowed = "texts of shape (N,) are needed";
  const py::array array = array_of(argument, value, allowed);
  if (array.ndim() != 1) throw InputError({described(array), allowed, argument});
  Faults faults;
  std::vector<std::string> texts;
  for (const py::handle item : array.attr("tolist")()) {
    const auto text = text_of(item);
    if (!text)
      faults.add({"is " + std::string(py::str(py::repr(item))),
                  "a text or a whole number is needed",
                  fmt::format("{}[{}]", argument, texts.size())});
    texts.push_back(text.value_or(""));
  }
  faults.throw_if_any(texts.size());
  return texts;
}

Eigen::MatrixXd matrix_of(const char* argument, const py::object& value, Eigen::Index rows,
                          Eigen::Index columns) {
  const std::string allowed = fmt::format("numbers of shape ({}, {}) are needed", rows, columns);
  const py::array_t<double> array = doubles_of(argument, value, allowed);
  if (array.ndim() != 2 || array.shape(0) != rows || array.shape(1) != columns)
    throw InputError({described(array), allowed, argument});
  Eigen::MatrixXd values(rows, columns);
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index c = 0; c < columns; ++c) values(r, c) = array.at(r, c);
  require_finite(argument, values);
  return values;
}

void require_metres(const char* argument, const Eigen::Ref<const Eigen::MatrixXd>& lengths) {
  constexpr double kFarthest_m = 10.0;  // fit_error_map() believes no more, either
  const double longest = lengths.size() == 0 ? 0.0 : lengths.cwiseAbs().maxCoeff();
  if (longest > kFarthest_m)
    throw InputError({fmt::format("has {:g} m, farther than arms reach", longest),
                      "lengths are metres here; divide millimetres by 1000", argument});
}

void require_radians(const char* argument, const Eigen::Ref<const Eigen::MatrixXd>& angles) {
  constexpr double kMost = 25.0;  // four turns
  const double most = angles.size() == 0 ? 0.0 : angles.cwiseAbs().maxCoeff();
  if (most > kMost)
    throw InputError({fmt::format("has {:g} rad, more than four turns", most),
                      "angles are radians here; numpy.radians() makes them", argument});
}

std::vector<Eigen::Vector2d> points_of(const char* argument, const py::object& value) {
  const Rows rows = rows_of(argument, value, 2);
  std::vector<Eigen::Vector2d> points;
  points.reserve(static_cast<std::size_t>(rows.count()));
  for (Eigen::Index i = 0; i < rows.count(); ++i) points.emplace_back(rows.values.row(i));
  return points;
}

cv::Mat image_of(const char* argument, const py::object& value) {
  constexpr py::ssize_t kLongestSide = 100000;
  const std::string allowed =
      "a grey picture is needed: uint8 of shape (rows, columns), each side from 1 to 100000, with "
      "the pixels of a row side by side; numpy.ascontiguousarray() and "
      "numpy.array(PIL.Image.open(FILE).convert('L')) make one";
  if (!py::isinstance<py::array>(value))
    throw InputError({"is of type " + type_name(value), allowed, argument});
  require_unmasked(argument, value);
  const auto array = py::reinterpret_borrow<py::array>(value);
  const bool is_grey =
      array.dtype().kind() == 'u' && array.dtype().itemsize() == 1 && array.ndim() == 2;
  if (!is_grey || array.shape(0) < 1 || array.shape(1) < 1 || array.shape(0) > kLongestSide ||
      array.shape(1) > kLongestSide)
    throw InputError({described(array), allowed, argument});
  if ((array.shape(1) > 1 && array.strides(1) != 1) || array.strides(0) < array.shape(1))
    throw InputError({fmt::format("{} with strides ({}, {})", described(array), array.strides(0),
                                  array.strides(1)),
                      allowed, argument});
  // A picture that is only read: OpenCV has no constant matrix.
  return {static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), CV_8UC1,
          const_cast<void*>(array.data()), static_cast<std::size_t>(array.strides(0))};
}

std::string point_text(const Eigen::Vector2d& p, int decimals) {
  return fmt::format("({:.{}f}, {:.{}f})", p.x(), decimals, p.y(), decimals);
}

std::string extent_text(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d low = points.at(0), high = low;
  for (const Eigen::Vector2d& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return fmt::format("from {} to {} m", point_text(low, 3), point_text(high, 3));
}

std::string type_name(const py::object& value) {
  return py::str(py::type::of(value).attr("__name__"));
}

double finite(const char* argument, double value) {
  if (!std::isfinite(value))
    throw InputError({fmt::format("is {}", value), "a finite number is needed", argument});
  return value;
}

Results::Results(const Rows& rows, std::initializer_list<py::ssize_t> shape)
    : size_(1), is_single_(rows.is_single) {
  std::vector<py::ssize_t> whole{rows.count()};
  for (const py::ssize_t length : shape) {
    whole.push_back(length);
    size_ *= length;
  }
  array_ = py::array_t<double>(whole);
  data_ = array_.mutable_data();
}

void Results::clear(py::ssize_t i) {
  std::fill_n(at(i), size_, std::numeric_limits<double>::quiet_NaN());
}

py::object Results::result() const {
  return is_single_ ? py::object(array_[py::int_(0)]) : py::object(array_);
}

py::array_t<double> array_from(const std::vector<Eigen::Vector2d>& points) {
  py::array_t<double> array({static_cast<py::ssize_t>(points.size()), py::ssize_t{2}});
  for (std::size_t i = 0; i < points.size(); ++i)
    for (Eigen::Index c = 0; c < 2; ++c)
      array.mutable_at(static_cast<py::ssize_t>(i), c) = points[i][c];
  return array;
}

void refuse_word(const char* argument, const std::string& word,
                 const std::vector<std::string>& allowed) {
  throw InputError({fmt::format("is '{}'", word),
                    fmt::format("allowed are {}", fmt::join(allowed, ", ")), argument});
}

}  // namespace planar::python
