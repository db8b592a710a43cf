#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "mesh/facet_table.h"

namespace tissue {

/// Discs that a law in space was trained under, beside its own, and how contacts of each are corrected for where the lattice stands.
struct DiscSizes {
    Eigen::VectorXd radii_m = {};             ///< ascending: of the training contacts, and half way between by ratio; none: the law knows its own disc alone (K)
    double spacing_m = std::numeric_limits<double>::quiet_NaN();  ///< edge of the lattice's cubes, which the law's rows at other radii go by
    std::vector<FacetTable> correction = {};  ///< of each (springs/lattice_correction.h); none where a lattice has no correction (K)

    bool empty() const { return radii_m.size() == 0; }
    /// The correction of a disc between the first and the last, interpolated over the logarithm of the radius; no rows where there is none.
    FacetTable correction_at(double radius_m) const;
    /// The same at weights of a facet's nodes, of any radius: below the first disc in proportion to the radius, since the smaller a contact is, the smaller is the lattice's part of its compliance;
    /// above the last one as of that. Allocates nothing.
    double correction_at(double radius_m, Eigen::Index facet, const Eigen::Vector3d& weight) const noexcept;

   private:
    struct Between {
        std::size_t below, above;
        double part;  ///< of the way from one to the other
    };
    Between between(double radius_m) const noexcept;
};

/// These radii and, between neighbours, the geometric mean: of a lattice's correction, which changes by less than its own size from one to the next. given_m: ascending (at least one).
Eigen::VectorXd with_means(const std::vector<double>& given_m);

}  // namespace tissue
