#pragma once

/// Common tolerances of the library's tests with their reasons. All are relative unless stated otherwise.
namespace tissue::tolerance {

/// Sums and products of a few hundred doubles of similar size: rounding of 2.2e-16 each, with a margin for the order of
/// summation.
inline constexpr double rounding = 1e-12;

/// One sparse solve: rounding times the condition number of a spring mesh of 25 to 121 nodes, below 1e4.
inline constexpr double solve = 1e-9;

/// Geometric springs at equilibrium: Newton stops at a residual force of 1e-10 of the contact force.
inline constexpr double newton = 1e-8;

/// Central difference with a step of 1e-3 relative to its variable: its error is of second order in the step.
inline constexpr double difference = 1e-6;

/// Deviation of the measured order of a second-order difference at the steps used here; absolute.
inline constexpr double order = 0.05;

/// Step of the logarithmic grid on which the uniform stiffness is searched.
inline constexpr double uniform_grid = 0.01;

}  // namespace tissue::tolerance
