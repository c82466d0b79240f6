#pragma once

namespace planar {

/// The chance at which one question put to sound measurements is answered with a doubt.
constexpr double kFalseAlarm = 1e-3;

/// Returns the chance that the squares of `degrees` independent standard normal numbers add up to
/// more than `square`. Throws std::invalid_argument unless there is at least one degree of freedom.
double chi_square_tail(double square, int degrees);

/// Returns the chance that at most `k` of `n` independent draws succeed, each with chance `p`.
double binomial_tail(int k, int n, double p);

/// Returns the chance that a mean square with two degrees of freedom exceeds one with `degrees` of
/// them, drawn from the same noise, by more than `ratio`.
double f_tail_of_two(double ratio, double degrees);

}  // namespace planar
