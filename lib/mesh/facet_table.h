#pragma once

#include <algorithm>

#include "field.h"

namespace tissue {

/// A scalar field on triangular facets. A facet is divided into parts^2 equal triangles, and the field is linear on
/// each. Their (parts + 1)(parts + 2) / 2 corners are numbered by i, then j. At corner (i, j) the weights of the
/// facet's nodes are (i, j, parts - i - j) / parts.
struct FacetTable {
    NodeField value;  ///< at each corner of each facet (F x V); no rows: 0 everywhere

    static int corner_count(int parts) { return (parts + 1) * (parts + 2) / 2; }
    /// `parts` of a table with this number of columns; 0 if no table has it.
    static int parts_of(Eigen::Index columns) {
        int parts = 1;
        while (corner_count(parts) < columns) ++parts;
        return corner_count(parts) == columns ? parts : 0;
    }
    /// Weights of the facet's nodes at the corners (V x 3).
    static NodeField corners(int parts) {
        NodeField weight(corner_count(parts), 3);
        for (int i = 0; i <= parts; ++i)
            for (int j = 0; i + j <= parts; ++j) weight.row(number(i, j, parts)) = Eigen::RowVector3d(i, j, parts - i - j) / parts;
        return weight;
    }

    /// Value at a point of a facet. weight: of the facet's nodes, >= 0, sum 1. Allocates nothing.
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
