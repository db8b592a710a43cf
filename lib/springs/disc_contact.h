#pragma once

#include "mesh/free_surface.h"
#include "springs/contact_kernel.h"
#include "springs/disc_tables.h"
#include "springs/polar_points.h"

namespace tissue {

/// Contact of a tapered disc on a surface in space: under it the tissue follows phi(r) d, phi = 1 - (r / R)^2 / 2 within its
/// radius R, without slip; the force that a hand feels is the one conjugate to d. Rows, all along the surface's inward
/// normal at the contact and along two tangents:
///   mean     d - sum_i w_i u_i, w the moving-least-squares weights of the surface's nodes within 1.6 spacings, which
///            sum to 1 and reproduce linear fields whatever the surface's mesh (Lancaster and Salkauskas 1981, Mathematics
///            of Computation 37: 141-158)
///   imprint  phi(r_i) d - u_i of every node within 2.5 R, times (1 - (r_i / 2.5 R)^2)^2: the shape that the disc presses in;
///            under the disc, to 1.2 R, up to five times as stiff, since there nothing slips and the shape is known.
///            Outside R phi is that of the half space which the same parabola is pressed into, Hertz's (Johnson, Contact
///            Mechanics, (3.42)): (2 - x^2) / pi asin(1 / x) + sqrt(x^2 - 1) / pi at x = r / R. Along the surface a half space
///            follows a force the more where it points to, (1 + cos^2) for incompressible tissue far away (Cerruti; Johnson,
///            (3.75)), and the imprint goes over to that with 1 - (R / r)^2
/// Where between the nodes it stands is `phase`: how far the nodes crowd there, as a sum of Gaussian bells of 0.35 spacings
/// about them, over its mean; scaled so that on a square lattice it is cos 2 pi x + cos 2 pi y over 2, to a tenth.
/// On a solid in an embedded lattice the disc stands on points of its own in place of the surface's nodes (springs/polar_points.h). Rows are the same, with weights and shares
/// of the points. They lie on a quadric over the tangent plane, fitted to the surface's nodes within 2.2 spacings, and 2.5 R at least. In place of `phase` is `curved`, R
/// times the mean curvature of that quadric: R / radius on a sphere, negative in a valley. All stiffnesses are exp(x) times as large, x DiscTables::correction.
/// What of the ground under it is of other stiffness is `ground`: to first order in log E / E_block the force changes by exp of
/// its mean, weighted with the energy that the disc stores there. Under a force on incompressible ground the stress is along
/// rays alone, as z / r^3 (Boussinesq; Johnson, (3.19)), so that the weight is z^2 / r^6, with R for what is nearer:
///   ground = sum_g (8 R / pi^2) z_g^2 / (R^2 + r_g^2)^3 weight_g, 1 for a half space with log E / E_block = 1 everywhere
/// Nodes round a crease do not belong to it. `curved` has no bounds of its own, and a stiffness is exponential in it: a trained law clamps it to the range of its training
/// contacts.
/// A contact has room for ToolSpring::most_nodes: where more are in reach it keeps the nearest. most_nodes() says how many
/// there can be; whoever plays a model refuses one that has more. On an embedded solid they are the 60 points.
class DiscContact final : public ContactKernel {
   public:
    /// Throws MismatchError for a radius that is not positive, and for a mesh that is no lattice.
    DiscContact(const SpringMesh& mesh, double radius_m, DiscTables tables = {});

    std::unique_ptr<ContactKernel> clone() const override { return std::make_unique<DiscContact>(*this); }
    ContactRows rows_at(const Point& contact_m) const override;  ///< at the surface's point nearest to that
    void tool_at(int facet, const Eigen::Vector3d& weight, const PatchLaw& law, ToolSpring& tool) const noexcept override;
    std::vector<SkinNode> skin_at(const Point& contact_m) const override;
    void show_skin(int facet, const Eigen::Vector3d& weight, const SkinLaw& skin, const Point& push_m, NodeColumns& u) const noexcept override;
    double spacing_m() const override { return surface_.spacing_m(); }

    /// Nodes that the widest contact has at the most: of one with its middle anywhere on a free facet.
    int most_nodes() const { return most_nodes_; }

    /// phi at r / R.
    static double profile(double x);
    /// `ground` of a contact there, `inward` into the tissue.
    double ground_at(const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward) const;

   private:
    struct Disc {
        Eigen::Vector3d normal;
        ContactFactors factors;
        double log_scale;
    };
    /// The contact at a place of the surface; fills the footing. Without means where too few nodes are near.
    Disc disc_at(const FreeSurface::Place& place, Footing& footing) const noexcept;
    void stand_on_nodes(const FreeSurface::Place& place, Footing& footing) const noexcept;

    /// Displacement per d of a half space's surface at a place from the contact: phi(r / R), outside the disc larger ahead of a tangential d and behind it than beside it.
    Eigen::Matrix3d target_at(const Eigen::Vector3d& from_m, double away_m, const Eigen::Vector3d& normal) const noexcept;
    /// Calls each(SkinNode) for the nodes of a place's skin.
    template <class Each>
    void each_skin_node(const FreeSurface::Place& place, Each&& each) const noexcept;

    SurfaceQuadric quadric_among(const std::vector<int>& nodes, double within_m, const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward) const noexcept;
    double curved_of(const SurfaceQuadric& quadric) const noexcept;
    double correction_at(const FreeSurface::Place& place) const noexcept;
    double own_reach_m() const noexcept;  ///< of the mean's weights

    /// A held facet: the free place nearest to its middle.
    struct Wall {
        Eigen::Index facet = 0;
        Eigen::Vector3d weight{1, 0, 0};
        Eigen::Vector3d inward = Eigen::Vector3d::Zero();
    };

    FreeSurface surface_;
    NodeField rest_;
    std::shared_ptr<const PolarPoints> polar_;  ///< of a solid in an embedded lattice
    std::vector<Wall> walls_;              ///< of each facet of the mesh; of free ones as made
    std::vector<std::vector<int>> near_;   ///< of each free facet: surface nodes in near_m_ of it, ascending
    double near_m_ = 0;
    int most_nodes_ = 0;
    double radius_m_;
    DiscTables tables_;
    std::vector<bool> fixed_;  ///< (N)
};

}  // namespace tissue
