#pragma once

#include "springs/element.h"

namespace tissue {

/// Area terms of the cells: energy A a (area / a - 1)^2 / 2, with the area of the polygon through the displaced corners
/// and a its area at rest.
/// Springs alone cannot conserve area. In a lattice of axial springs whose nodes are centres of symmetry, Lame's two
/// constants are equal (Cauchy's relation): Poisson's ratio is 1/3 in the plane and 1/4 in space, whatever the
/// stiffnesses. An energy of the volume alone adds to lambda and gives any other ratio (Golec, Palierne, Zara, Nicolle
/// and Damiand 2020, The Visual Computer 36: 809-825). Two dimensions.
class CellAreas final : public Elements {
   public:
    /// Throws MismatchError for a mesh that is not plane, and for a cell that is clockwise or has no area.
    explicit CellAreas(const SpringMesh& mesh);

    std::string kind() const override { return "cell"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

    /// Current area over area at rest; not positive where the cell is inverted.
    double area_ratio(int e, const NodeField& u) const;

   private:
    double swelling(int e, const NodeField& u) const;  ///< area / a - 1
    void area_gradient(int e, const NodeField& u, ElementVector& out) const;

    NodeField rest_;        ///< rest positions [m] (N x 2)
    Eigen::VectorXd area_;  ///< a [m^2] (C)
};

}  // namespace tissue
