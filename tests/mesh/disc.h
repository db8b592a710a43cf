#pragma once

#include <cmath>

#include "mesh/shape.h"

namespace tissue {

/// A disc of n sides and radius 0.05 m around the origin. The first quarter of its outline is fixed.
inline Shape disc(int n) {
    Shape shape;
    shape.nodes.resize(n + 1, 2);
    shape.simplices.resize(n, 3);
    shape.nodes.row(n) << 0, 0;
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::acos(-1.0) * i / n;
        shape.nodes.row(i) << 0.05 * std::cos(angle), 0.05 * std::sin(angle);
        shape.simplices.row(i) << i, (i + 1) % n, n;
        shape.region.push_back(0);
        if (i < n / 4) shape.fixed_edges.push_back({i, (i + 1) % n});
    }
    return shape;
}

}  // namespace tissue
