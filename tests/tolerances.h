#pragma once

/// Every tolerance of the library's tests, with its reason. All are relative unless they say otherwise.
namespace tissue::tolerance {

/// Sums and products of a few hundred doubles of one size: 2.2e-16 each, with room for the order of summation.
inline constexpr double rounding = 1e-12;

/// One sparse solve: rounding times the condition number of a spring mesh of 25 to 121 nodes, below 1e4.
inline constexpr double solve = 1e-9;

/// Geometric springs at equilibrium: Newton stops at an out-of-balance force of 1e-10 of the contact's.
inline constexpr double newton = 1e-8;

/// A central difference of step 1e-3 of what it differs by: its own error goes with the step squared.
inline constexpr double difference = 1e-6;

/// Measured order of a second-order difference at the steps used here; absolute.
inline constexpr double order = 0.05;

/// The uniform stiffness is looked for on a logarithmic grid of this step.
inline constexpr double uniform_grid = 0.01;

}  // namespace tissue::tolerance
