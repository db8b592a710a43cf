#pragma once

#include <Eigen/Core>
#include <memory>

#include "springs/ball_contact.h"
#include "springs/contact_patch.h"
#include "springs/patch_sizes.h"
#include "springs/tissue_model.h"
#include "springs/tool_spring.h"

namespace tissue {

/// Contacts of one tool on a mesh's boundary, in the form of the tick. Their energy is that of training and evaluation
/// (ContactKernel::tool_at). Holds constants, no state.
class ToolContact {
   public:
    /// energy_model: energy model of the tool (with_tool() in springs/energy_model_at_radius.h). ball_m: radius of the ball that
    /// is the tool [m]; 0: the disc or patch of `energy_model`. Throws MismatchError as make_contact_kernel() and PatchSizes do.
    ToolContact(const SpringMesh& mesh, const EnergyModel& energy_model, double ball_m);
    ToolContact(const ToolContact& other);
    ToolContact(ToolContact&&) = default;

    /// Sets `tool` to the contact at a place of the mesh's boundary. facet, weight: the place. push_m: tool displacement
    /// d (D). A ball's contact depends on d and u (springs/ball_indentation.h); any other does not. On entry `tool` is
    /// the same contact at the previous tick, or a tool without growth where the contact is new. Allocates nothing.
    void at(int facet, const Eigen::Vector3d& weight, const Point& push_m, const NodeColumns& u, ToolSpring& tool) const noexcept;
    /// The same for a given growth, as of a ball. A growth of radius 0 gives the contact of the disc or patch.
    void at(int facet, const Eigen::Vector3d& weight, const ToolSpring::Growth& growth, ToolSpring& tool) const noexcept;
    bool grows() const { return ball_.radius_m > 0; }  ///< with the tool displacement: a ball's

    /// Replaces displacements u near the tool by the displayed ones (ContactKernel::show_skin). Allocates nothing.
    void show_skin(int facet, const Eigen::Vector3d& weight, const Point& push_m, NodeColumns& u) const noexcept;

    /// Replaces the contact stiffnesses by others of the same sizes, and the log of their factor at each node (N).
    /// Allocates nothing.
    void become(const ContactParameters& patch, const Eigen::VectorXd& log_scale) noexcept;
    /// The factor alone.
    void scale(const Eigen::VectorXd& log_scale) noexcept { kernel_->scale(log_scale); }

    double spacing_m() const { return kernel_->spacing_m(); }  ///< mean distance of the free surface's nodes

   private:
    /// Contact of a ball at a place and a tool displacement (springs/ball_contact.h).
    struct BallAt {
        Eigen::Vector3d push_m, inward;
        /// R_e, depth d, contact radius a [m], and da / dd [1], which is 0 where a is the smallest radius
        double effective_m, depth_m, radius_m, growth;
    };
    BallAt ball_at(int facet, const Eigen::Vector3d& weight, const Point& push_m) const noexcept;

    std::unique_ptr<ContactKernel> kernel_;
    ContactParameters patch_;
    SkinParameters skin_;
    BallContact ball_;   ///< radius 0: the tool is no ball
    PatchSizes sizes_;   ///< contact stiffnesses by radius, for a ball
};

}  // namespace tissue
