#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "field.h"
#include "springs/skin.h"
#include "springs/tool_spring.h"

namespace tissue {

struct PatchLaw;

/// Factors of a contact's place that its stiffnesses depend on (PatchLaw): four.
using ContactFactors = Eigen::Vector4d;

/// Where a contact lies: what its rows take of the push d and of the displacements of a few nodes, e = push d - pull u, and
/// which of the law's stiffnesses each of them has.
struct ContactRows {
    std::vector<int> nodes;      ///< (K), none twice
    Eigen::MatrixXd push;        ///< (R x D)
    Eigen::MatrixXd pull;        ///< (R x D*K), columns D * node + axis
    std::vector<std::vector<int>> touched;  ///< of each three rows in their order, the nodes (of K) whose columns of pull are not zero; empty: every row takes all nodes
    std::vector<int> law_row;    ///< of PatchLaw, for each row (R)
    Eigen::VectorXd share;       ///< of that stiffness (R)
    ContactFactors factors;      ///< of the place: PatchLaw's
    Eigen::VectorXd mean;        ///< weight of each node in ContactKernel::scale (K): those of the first rows of pull, over their sum
    double log_scale = 0;        ///< of the law's stiffnesses there: ContactKernel::scale, and of a disc DiscTables::correction
};

/// Makes contacts of one kind on the surface of one mesh: the patch in the plane (springs/contact_patch.h), the disc in
/// space (springs/disc_contact.h). Const, and serves many threads.
class ContactKernel {
   public:
    virtual ~ContactKernel() = default;
    virtual std::unique_ptr<ContactKernel> clone() const = 0;

    virtual ContactRows rows_at(const Point& contact_m) const = 0;
    /// The same contact as the tick holds it, at weights of the nodes of a boundary facet (SpringMesh::facets). On a held facet,
    /// which is no part of the free surface, a wall as stiff as the contact nearby. Allocates nothing.
    /// radius_m: of a disc, of whose radius the law has to be; 0: the kernel's own.
    virtual void tool_at(int facet, const Eigen::Vector3d& weight, double radius_m, const PatchLaw& law, ToolSpring& tool) const noexcept = 0;
    /// In space, the surface there: unit normal into the tissue, and mean curvature [1/m], positive where it bulges.
    struct SurfaceAt {
        Eigen::Vector3d inward = Eigen::Vector3d::Zero();
        double curvature_1_m = 0;
    };
    virtual SurfaceAt surface_at(int /*facet*/, const Eigen::Vector3d& /*weight*/) const noexcept { return {}; }
    /// Nodes whose displacement follows the tool's (springs/skin.h); none in the plane.
    virtual std::vector<SkinNode> skin_at(const Point& /*contact_m*/) const { return {}; }
    /// The same at weights of the nodes of a boundary facet, put into displacements of all nodes [m] (N x D). Allocates nothing.
    virtual void show_skin(int /*facet*/, const Eigen::Vector3d& /*weight*/, double /*radius_m*/, const SkinLaw& /*skin*/, const Point& /*push_m*/, NodeColumns& /*u*/) const noexcept {}
    /// Node pairs that contacts anywhere couple, where they are few; else none, and each contact brings its own.
    virtual std::vector<std::pair<int, int>> coupled() const { return {}; }
    virtual double spacing_m() const = 0;  ///< of the surface's nodes

    /// Contacts become exp(.) as stiff, by node (N) and with a contact's own mean between them: where the tissue itself is stiffer or softer
    /// than what the law knows of the place (adapt/unknowns.h). Of no rows: as the law says. Of as many rows as before: no allocation.
    void scale(const Eigen::VectorXd& log_scale) { log_scale_ = log_scale; }

   protected:
    double log_scale_of(int node) const noexcept { return log_scale_.size() > 0 ? log_scale_[node] : 0; }

   private:
    Eigen::VectorXd log_scale_;
};

}  // namespace tissue
