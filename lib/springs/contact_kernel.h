#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "field.h"
#include "springs/skin.h"
#include "springs/tool_spring.h"

namespace tissue {

struct ContactParameters;

/// The four factors of a contact's place on which its stiffnesses depend (ContactParameters).
using ContactFactors = Eigen::Vector4d;

/// Kinematics of one contact in R rows: e = push d - pull u, with the tool displacement d [m] (D) and the displacements
/// u of K nodes. The stiffness of row r is share_r times that of the row contact_row_r of ContactParameters.
struct ContactRows {
    std::vector<int> nodes;      ///< (K), all different
    Eigen::MatrixXd push;        ///< (R x D)
    Eigen::MatrixXd pull;        ///< (R x D*K), column D * node + axis
    /// for each group of three rows, the nodes (of K) with non-zero columns of pull; empty: all nodes for every row
    std::vector<std::vector<int>> touched;
    std::vector<int> parameter_row;    ///< row of ContactParameters (R)
    Eigen::VectorXd share;       ///< part of that stiffness (R)
    ContactFactors factors;      ///< factors of the place for ContactParameters
    Eigen::VectorXd mean;        ///< weights of the nodes for ContactKernel::scale (K), sum 1
    /// log of the factor on all stiffnesses: ContactKernel::scale, and for a disc also DiscTables::correction
    double log_scale = 0;
};

/// Makes contacts of one kind on the surface of one mesh: the patch in the plane (springs/contact_patch.h), the disc in
/// space (springs/disc_contact.h). Its const methods may be called by many threads at once.
class ContactKernel {
   public:
    virtual ~ContactKernel() = default;
    virtual std::unique_ptr<ContactKernel> clone() const = 0;

    virtual ContactRows rows_at(const Point& contact_m) const = 0;
    /// The same contact in the form of the tick (ToolSpring), at weights of the nodes of a boundary facet
    /// (SpringMesh::facets). On a fixed facet, which is not part of the free surface, it is a fixed wall with the
    /// stiffness of the nearest contact. Allocates nothing.
    /// radius_m: radius of a disc [m], to which `contact_parameters` must belong; 0: the kernel's own.
    virtual void tool_at(int facet, const Eigen::Vector3d& weight, double radius_m, const ContactParameters& contact_parameters, ToolSpring& tool) const noexcept = 0;
    /// In space, the surface at a place: unit normal into the tissue, and mean curvature [1/m], positive where the
    /// surface bulges.
    struct SurfaceAt {
        Eigen::Vector3d inward = Eigen::Vector3d::Zero();
        double curvature_1_m = 0;
    };
    virtual SurfaceAt surface_at(int /*facet*/, const Eigen::Vector3d& /*weight*/) const noexcept { return {}; }
    /// Nodes whose displayed displacement follows the tool (springs/skin.h); none in the plane.
    virtual std::vector<SkinNode> skin_at(const Point& /*contact_m*/) const { return {}; }
    /// Writes the displayed displacement of these nodes into u [m] (N x D), at weights of the nodes of a boundary
    /// facet. Allocates nothing.
    virtual void show_skin(int /*facet*/, const Eigen::Vector3d& /*weight*/, double /*radius_m*/, const SkinParameters& /*skin*/, const Point& /*push_m*/, NodeColumns& /*u*/) const noexcept {}
    /// Node pairs that any contact can couple, where they are few. Empty otherwise: then each contact has its own
    /// pairs.
    virtual std::vector<std::pair<int, int>> coupled() const { return {}; }
    virtual double spacing_m() const = 0;  ///< mean spacing of the surface's nodes [m]

    /// Sets log stiffness factors by node (N). A contact's stiffness is multiplied by exp of their mean, weighted by
    /// ContactRows::mean. Adaptation sets them where it finds the tissue stiffer or softer than the energy model
    /// (adapt/unknowns.h). Empty: no factors. Allocates nothing if the size does not change.
    void scale(const Eigen::VectorXd& log_scale) { log_scale_ = log_scale; }

   protected:
    double log_scale_of(int node) const noexcept { return log_scale_.size() > 0 ? log_scale_[node] : 0; }

   private:
    Eigen::VectorXd log_scale_;
};

}  // namespace tissue
