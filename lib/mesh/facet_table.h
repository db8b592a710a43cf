#pragma once

#include <algorithm>

#include "field.h"

namespace tissue {

/// A scalar over triangular facets, linear over parts of each. A facet has parts^2 equal triangles; their (parts + 1)(parts + 2) / 2 corners are numbered by i, then j, at
/// weights (i, j, parts - i - j) / parts of its nodes.
struct FacetTable {
    NodeField value;  ///< of each facet at each corner (F x V); no rows: 0 everywhere

    static int corner_count(int parts) { return (parts + 1) * (parts + 2) / 2; }
    /// Parts of a table of so many columns; 0 where no table has them.
    static int parts_of(Eigen::Index columns) {
        int parts = 1;
        while (corner_count(parts) < columns) ++parts;
        return corner_count(parts) == columns ? parts : 0;
    }
    /// Weights of the corners (V x 3).
    static NodeField corners(int parts) {
        NodeField weight(corner_count(parts), 3);
        for (int i = 0; i <= parts; ++i)
            for (int j = 0; i + j <= parts; ++j) weight.row(number(i, j, parts)) = Eigen::RowVector3d(i, j, parts - i - j) / parts;
        return weight;
    }

    /// At weights of a facet's nodes, which are >= 0 and sum to 1. Allocates nothing.
    double at(Eigen::Index facet, const Eigen::Vector3d& weight) const noexcept {
        if (value.rows() == 0) return 0;
        const int parts = parts_of(value.cols());
        const double a = parts * weight[0], b = parts * weight[1];
        const int i = std::clamp(static_cast<int>(a), 0, parts - 1), j = std::clamp(static_cast<int>(b), 0, parts - 1 - i);
        const double x = a - i, y = b - j;
        const auto of = [&](int k, int l) { return value(facet, number(k, l, parts)); };
        if (x + y <= 1 || i + j == parts - 1) return (1 - x - y) * of(i, j) + x * of(i + 1, j) + y * of(i, j + 1);
        return (x + y - 1) * of(i + 1, j + 1) + (1 - x) * of(i, j + 1) + (1 - y) * of(i + 1, j);
    }

   private:
    static int number(int i, int j, int parts) { return i * (parts + 1) - i * (i - 1) / 2 + j; }
};

}  // namespace tissue
