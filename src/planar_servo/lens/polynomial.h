#pragma once

#include <Eigen/Core>
#include <initializer_list>

namespace planar::lens {

/// Holds the coefficients of a polynomial of degree 7 or less, the constant first, and never
/// allocates memory on the heap.
using Polynomial = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 8, 1>;

Polynomial polynomial(std::initializer_list<double> coefficients);

double value(const Polynomial& a, double s);
Polynomial derivative(const Polynomial& a);
Polynomial product(const Polynomial& a, const Polynomial& b);

/// Returns whether the polynomial is positive on the whole interval [0, end]. Its Bernstein
/// coefficients decide, and the interval is halved while they leave the question open [Farouki &
/// Rajan 1987]. A minimum so close to zero that 20 halvings do not decide counts as not positive.
bool positive_up_to(double end, const Polynomial& a);

}  // namespace planar::lens
