#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "mesh/facet_table.h"

namespace tissue {

/// Disc radii under which a model in space was trained, and the lattice corrections of the contact at each.
struct DiscSizes {
    /// radii [m], ascending (K): those of the training contacts and the geometric means between neighbours; empty: the
    /// model has one disc only
    Eigen::VectorXd radii_m = {};
    /// cube edge h of the lattice [m], on which the contact stiffnesses at other radii depend
    double spacing_m = std::numeric_limits<double>::quiet_NaN();
    /// correction at each radius (K) (springs/lattice_correction.h); empty where the lattice has none
    std::vector<FacetTable> correction = {};

    bool empty() const { return radii_m.size() == 0; }
    /// Correction of a disc between the smallest and the largest radius, interpolated linearly in log radius; no rows
    /// where there is none.
    FacetTable correction_at(double radius_m) const;
    /// Correction of a contact of any radius at weights of a facet's nodes. Below the smallest disc it is proportional
    /// to the radius, because the lattice's part of the compliance decreases with the contact. Above the largest disc
    /// it is constant. Allocates nothing.
    double correction_at(double radius_m, Eigen::Index facet, const Eigen::Vector3d& weight) const noexcept;

   private:
    struct Between {
        std::size_t below, above;
        double part;  ///< fraction of the interval
    };
    Between between(double radius_m) const noexcept;
};

/// The given radii and the geometric mean of each two neighbours. From one to the next a lattice's correction changes
/// by less than its own size. given_m: ascending [m], at least one.
Eigen::VectorXd with_means(const std::vector<double>& given_m);

}  // namespace tissue
