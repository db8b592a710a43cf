#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "springs/cell_areas.h"
#include "springs/cell_volumes.h"
#include "springs/spring_curve.h"
#include "springs/supports.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Energy of a piece of tissue: springs that rotate with the tissue and cells that conserve area or volume, each with
/// its own constant. Its forces are conservative. It does not change under translation and rotation (except for the
/// supports), and is zero at rest. constants (E): theta of the springs (S) [N/m], then A of the cells (C), in the plane
/// [N/m], in space [Pa].
///
/// Cells in the plane are the squares of a lattice, about one per node. A shape has two triangles per node, thus as
/// many area constraints as displacements: it would lock. There a cell consists of all triangles around a node (average
/// nodal area: Bonet and Burton 1998, Communications in Numerical Methods in Engineering 14: 437-449). Three such cells
/// overlap everywhere.
///
/// In space a solid is embedded in a lattice. It has the lattice's springs, the volumes of its cubes, each with the
/// part of it that is tissue, and supports at the nodes of its fixed surface, whose stiffnesses [N/m] are the last
/// constants (M). No element joins the solid's own nodes.
///
/// Incompressible tissue in the plane also conserves the area of the whole and of its quarters; A of these regions are
/// the last constants (R). The time step limits the stiffness of the cells. Their small losses of area add up over the
/// tissue, which would then bulge too little. Regions have small stiffnesses at many nodes and cost little time step:
/// at the cells' own A the fastest mode on the 10 mm lattice rises by 4 %. Cells of the stiffness that has the same
/// effect would cost 20 %.
class TissueEnergy {
   public:
    /// incompressible: in the plane, whether there are regions; ignored in space. curve: force curve of the springs.
    TissueEnergy(const SpringMesh& mesh, bool incompressible, const SpringCurve& curve = {});

    /// Energy of an energy model on its mesh. Throws MismatchError where the model has another number of constants.
    TissueEnergy(const SpringMesh& mesh, const EnergyModel& energy_model);

    const std::vector<std::unique_ptr<Elements>>& kinds() const { return kinds_; }
    int first_of(std::size_t kind) const { return first_[kind]; }  ///< index of its first constant
    int constant_count() const { return first_.back(); }
    int node_count() const { return nodes_; }
    int dimension() const { return dimension_; }
    /// nodes that are not unknowns: the fixed ones, or all own nodes of an embedded solid
    const std::vector<int>& dependent() const { return dependent_; }
    /// sets an embedded solid's own rows from those of its lattice (N x .)
    void complete(Eigen::Ref<NodeField> u) const { embedding_.interpolate(u); }

    double energy(const Eigen::VectorXd& constants, const NodeField& u) const;  ///< W [J]
    /// dW/du: external force that holds u [N] (N x D)
    NodeField force(const Eigen::VectorXd& constants, const NodeField& u) const;
    Eigen::SparseMatrix<double> tangent(const Eigen::VectorXd& constants, const NodeField& u) const;  ///< (N*D x N*D)

    /// Smallest ratio of current to rest area (of a lattice's squares or a shape's triangles) or volume (of cells in
    /// space). A cell is inverted if it is 0 or less. The cell around a node may conserve its area although one of its
    /// triangles is inverted.
    double smallest_ratio(const NodeField& u) const;

   private:
    std::unique_ptr<CellAreas> areas_;       ///< in the plane
    const CellVolumes* volumes_ = nullptr;   ///< in space: the element of kinds_
    std::vector<std::unique_ptr<Elements>> kinds_;
    std::vector<int> first_;
    Embedding embedding_;
    int nodes_, dimension_;
    std::vector<int> dependent_;
};

}  // namespace tissue
