#pragma once

#include <vector>

#include "springs/element.h"

namespace tissue {

/// Cubes of an embedded lattice that keep the true volume V of the tissue in them: A V (J - 1)^2 / 2, J the determinant of the trilinear map's
/// deformation gradient at that tissue's centroid (one-point quadrature; what it does not see, springs hold). Constants A are moduli [Pa]; per unit of them energies are [m^3].
/// What springs alone cannot do is in springs/cell_areas.h.
class CellVolumes final : public Elements {
   public:
    /// Throws MismatchError for a mesh that is no embedded lattice, and a cell turned inside out or without volume.
    explicit CellVolumes(const SpringMesh& mesh);

    std::string kind() const override { return "cell"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

    /// J; not positive where the cell has turned inside out.
    double volume_ratio(int e, const NodeField& u) const;
    const Eigen::VectorXd& volumes() const { return volume_; }  ///< V [m^3] (C)
    /// Gradients of the corners' hat functions where J is taken [1/m].
    const Eigen::Matrix<double, 3, 8>& gradient(int e) const { return gradient_[static_cast<std::size_t>(e)]; }

   private:
    Eigen::Matrix3d displacement_gradient(int e, const NodeField& u) const;  ///< F - I of the cell

    Eigen::VectorXd volume_;
    std::vector<Eigen::Matrix<double, 3, 8>> gradient_;  ///< (C)
};

}  // namespace tissue
