#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "springs/tool_spring.h"

namespace tissue {

/// (1 - x^2)^2 for |x| <= 1, 0 beyond.
inline double quartic_kernel(double x) noexcept {
    const double fall = std::max(0.0, 1 - x * x);
    return fall * fall;
}

/// phi of a disc at x = r / R (springs/disc_contact.h): its parabola for x <= 1, beyond it the surface displacement of
/// the half space.
inline double disc_profile(double x) noexcept {
    constexpr double pi = 3.14159265358979323846;
    return x <= 1 ? 1 - x * x / 2 : ((2 - x * x) * std::asin(1 / x) + std::sqrt(x * x - 1)) / pi;
}

/// Profile of the tangential displacement at x = r / R on a half space, where the contact is bound within R and moves
/// as one: that of a rigid flat punch (Johnson, (3.75)).
inline double bound_profile(double x) noexcept {
    constexpr double pi = 3.14159265358979323846;
    return x <= 1 ? 1 : 2 / pi * std::asin(1 / x);
}

/// Points of the surface to which a disc's contact is coupled, each of which moves with a few nodes. Fixed storage:
/// nothing allocates.
struct Footing {
    static constexpr int most_points = ToolSpring::most_nodes;

    struct Point {
        Eigen::Matrix3d target;  ///< displacement imposed by the disc, per d
        double share;            ///< share of the imprint's stiffness
        int begin, end;          ///< range of its nodes in node[], weight[]
    };

    Point point[most_points];
    int points = 0;
    /// number of the mean's nodes: the first of node[], all different; their weights sum to PolarPoints::total
    int means = 0;
    int entries = 0;
    int node[ToolSpring::most_entries];
    double weight[ToolSpring::most_entries];

    void add(int of, double by) noexcept {
        if (entries == ToolSpring::most_entries) return;
        node[entries] = of;
        weight[entries++] = by;
    }
};

}  // namespace tissue
