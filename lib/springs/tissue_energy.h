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

/// The energy that a piece of tissue stores: turning springs and cells that keep their area, each with a constant of its
/// own. Derives forces that give back what they took on every closed loop, feels no translation and no rotation, and is
/// zero at rest. constants [N/m] (E): theta of the springs (S), then A of the cells (C).
///
/// Cells are a lattice's squares, about one a node. A shape has two triangles a node, and as many areas to keep as there
/// are displacements: it would lock. There a cell is what lies around a node, all its triangles together (average nodal
/// area: Bonet and Burton 1998, Communications in Numerical Methods in Engineering 14: 437-449); three of them lie over
/// each other everywhere.
///
/// In space a solid is embedded in a lattice: it has the lattice's springs, its cubes' volumes, each with the part of it that is tissue, and supports at the points of its held
/// surface, whose stiffness [N/m] are the last constants (M). No element joins the solid's own nodes.
///
/// An incompressible tissue in the plane keeps its area as a whole and by quarters too, A of those regions the last constants (R): what
/// the cells lose one by one, since a time step bounds how stiff they may be, adds up over the tissue, and it bulges too
/// little. Regions pull softly at many nodes and cost the time step next to nothing: at the cells' own A 4 % of the fastest
/// mode on the 10 mm lattice, where making the cells as stiff as that helps would cost 20 %.
class TissueEnergy {
   public:
    /// incompressible: in the plane whether there are regions; in space it means nothing. curve: of the springs.
    TissueEnergy(const SpringMesh& mesh, bool incompressible, const SpringCurve& curve = {});

    /// Of a law, on the mesh it is of.
    TissueEnergy(const SpringMesh& mesh, const LawModel& law) : TissueEnergy(mesh, law.incompressible, law.curve) {}

    const std::vector<std::unique_ptr<Elements>>& kinds() const { return kinds_; }
    int first_of(std::size_t kind) const { return first_[kind]; }  ///< its first constant
    int constant_count() const { return first_.back(); }
    int node_count() const { return nodes_; }
    int dimension() const { return dimension_; }
    const std::vector<int>& dependent() const { return dependent_; }  ///< nodes that are no unknowns: held ones, of an embedded solid all its own
    void complete(Eigen::Ref<NodeField> u) const { embedding_.interpolate(u); }   ///< an embedded solid's own rows from the lattice's (N x .)

    double energy(const Eigen::VectorXd& constants, const NodeField& u) const;  ///< W [J]
    NodeField force(const Eigen::VectorXd& constants, const NodeField& u) const;  ///< dW/du: what holds u [N] (N x D)
    Eigen::SparseMatrix<double> tangent(const Eigen::VectorXd& constants, const NodeField& u) const;  ///< (N*D x N*D)

    /// Smallest area, of a lattice's square or a shape's triangle, or volume of a cell in space, over that at rest: 0 or
    /// less, and it has turned inside out, where what lies around a node may still have its area.
    double smallest_ratio(const NodeField& u) const;

   private:
    std::unique_ptr<CellAreas> areas_;       ///< in the plane
    const CellVolumes* volumes_ = nullptr;   ///< in space: of kinds_
    std::vector<std::unique_ptr<Elements>> kinds_;
    std::vector<int> first_;
    Embedding embedding_;
    int nodes_, dimension_;
    std::vector<int> dependent_;
};

}  // namespace tissue
