#pragma once

#include <vector>

#include "springs/element.h"

namespace tissue {

/// Volume terms of the cubes of an embedded lattice: energy A V (J - 1)^2 / 2. V is the volume of the tissue in the
/// cube, J the determinant of the deformation gradient of the trilinear map at that tissue's centroid. This one-point
/// quadrature leaves hourglass modes free, which the springs resist. The constants A are moduli [Pa], so energies per
/// unit constant are in [m^3].
/// Why springs alone do not suffice: springs/cell_areas.h.
class CellVolumes final : public Elements {
   public:
    /// Throws MismatchError for a mesh that is not an embedded lattice, and for a cell that is inverted or has no
    /// volume.
    explicit CellVolumes(const SpringMesh& mesh);

    std::string kind() const override { return "cell"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

    /// J; not positive where the cell is inverted.
    double volume_ratio(int e, const NodeField& u) const;
    const Eigen::VectorXd& volumes() const { return volume_; }  ///< V [m^3] (C)
    /// Gradients of the trilinear shape functions of the eight corners at the centroid [1/m].
    const Eigen::Matrix<double, 3, 8>& gradient(int e) const { return gradient_[static_cast<std::size_t>(e)]; }

   private:
    Eigen::Matrix3d displacement_gradient(int e, const NodeField& u) const;  ///< F - I of the cell

    Eigen::VectorXd volume_;
    std::vector<Eigen::Matrix<double, 3, 8>> gradient_;  ///< (C)
};

}  // namespace tissue
