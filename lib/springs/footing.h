#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "springs/tool_spring.h"

namespace tissue {

/// (1 - x^2)^2, nothing beyond 1.
inline double bell(double x) noexcept {
    const double fall = std::max(0.0, 1 - x * x);
    return fall * fall;
}

/// What a disc takes of the nodes about it: points of the surface, each of which moves with one node or a few. Storage of its own: nothing allocates.
struct Footing {
    static constexpr int most_points = ToolSpring::most_nodes;

    struct Point {
        Eigen::Matrix3d target;  ///< how far it goes under the disc, by d
        double share;            ///< of the imprint's stiffness
        int begin, end;          ///< of its nodes in node[], weight[]
    };

    Point point[most_points];
    int points = 0;
    int means = 0;        ///< the mean's are the first of node[], weight[], none twice; a weight may be 0
    double mean_sum = 1;  ///< of its weights
    int entries = 0;
    int node[ToolSpring::most_entries];
    double weight[ToolSpring::most_entries];
    double phase = 0;  ///< factor of the place: springs/disc_contact.h

    void add(int of, double by) noexcept {
        if (entries == ToolSpring::most_entries) return;
        node[entries] = of;
        weight[entries++] = by;
    }
};

}  // namespace tissue
