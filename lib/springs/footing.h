#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "springs/tool_spring.h"

namespace tissue {

/// (1 - x^2)^2, nothing beyond 1.
inline double bell(double x) noexcept {
    const double fall = std::max(0.0, 1 - x * x);
    return fall * fall;
}

/// phi of a disc at r / R, springs/disc_contact.h: the parabola that it presses in, and outside it that of the half space.
inline double disc_profile(double x) noexcept {
    constexpr double pi = 3.14159265358979323846;
    return x <= 1 ? 1 - x * x / 2 : ((2 - x * x) * std::asin(1 / x) + std::sqrt(x * x - 1)) / pi;
}

/// Of what is bound within R and moved along the surface as one, on a half space: Johnson, (3.75), as of a rigid flat punch.
inline double bound_profile(double x) noexcept {
    constexpr double pi = 3.14159265358979323846;
    return x <= 1 ? 1 : 2 / pi * std::asin(1 / x);
}

/// What a disc takes of the nodes about it: points of the surface, each of which moves with a few. Storage of its own: nothing allocates.
struct Footing {
    static constexpr int most_points = ToolSpring::most_nodes;

    struct Point {
        Eigen::Matrix3d target;  ///< how far it goes under the disc, by d
        double share;            ///< of the imprint's stiffness
        int begin, end;          ///< of its nodes in node[], weight[]
    };

    Point point[most_points];
    int points = 0;
    int means = 0;        ///< the mean's are the first of node[], weight[], none twice; their weights sum to PolarPoints::total
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
