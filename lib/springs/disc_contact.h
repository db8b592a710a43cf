#pragma once

#include "mesh/free_surface.h"
#include "springs/contact_kernel.h"
#include "springs/disc_tables.h"
#include "springs/polar_points.h"

namespace tissue {

/// Contact of a tapered disc on a surface in space: under it the tissue follows phi(r) d, phi = 1 - (r / R)^2 / 2 within its
/// radius R, without slip; the force that a hand feels is the one conjugate to d. Rows, all along the surface's inward
/// normal at the contact and along two tangents:
///   mean     d - sum_i w_i u_i over points of the surface, weights that sum to 5/4, as the pressure on the tissue is 5/4 of the hand's force
///   imprint  phi(r_i) d - u_i of each point within 2.5 R: the shape that the disc presses in.
///            Outside R phi is that of the half space which the same parabola is pressed into, Hertz's (Johnson, Contact
///            Mechanics, (3.42)): (2 - x^2) / pi asin(1 / x) + sqrt(x^2 - 1) / pi at x = r / R. Along the surface a half space
///            follows a force the more where it points to, (1 + cos^2) for incompressible tissue far away (Cerruti; Johnson,
///            (3.75)), and the imprint goes over to that with 1 - (R / r)^2
/// The points are the disc's own, with weights and shares: springs/polar_points.h. They lie on a quadric over the tangent plane, fitted to the surface's nodes within 2.2
/// spacings, 2.5 R and as far as the mean reaches at least; each moves as the cube of the lattice does in which it lies. `curved` is R times the mean curvature of that quadric: R / radius on a sphere,
/// negative in a valley. All stiffnesses are exp(x) times as large, x DiscTables::correction.
/// What of the ground under it is of other stiffness is `ground`: to first order in log E / E_block the force changes by exp of
/// its mean, weighted with the energy that the disc stores there. Under a force on incompressible ground the stress is along
/// rays alone, as z / r^3 (Boussinesq; Johnson, (3.19)), so that the weight is z^2 / r^6, with R for what is nearer:
///   ground = sum_g (8 R / pi^2) z_g^2 / (R^2 + r_g^2)^3 weight_g, 1 for a half space with log E / E_block = 1 everywhere
/// A ball's contact (DiscTables::ball_contact_m) is bound: along the surface all of it moves as one, where a disc's tapers off. Its imprint along the surface has bound_profile; its mean weights of 1 in place of 5/4, since the
/// hand's force is all that the tissue gets, and the stiffness 15/8 of the disc's: (16/9) E R over 64/45 E R 2/3.
/// Nodes round a crease do not belong to it. `curved` has no bounds of its own, and a stiffness is exponential in it: a trained law clamps it to the range of its training
/// contacts.
class DiscContact final : public ContactKernel {
   public:
    /// Throws MismatchError for a radius that is not positive, and for a mesh that is no embedded lattice.
    DiscContact(const SpringMesh& mesh, double radius_m, DiscTables tables = {});

    std::unique_ptr<ContactKernel> clone() const override { return std::make_unique<DiscContact>(*this); }
    ContactRows rows_at(const Point& contact_m) const override;  ///< at the surface's point nearest to that
    void tool_at(int facet, const Eigen::Vector3d& weight, double radius_m, const PatchLaw& law, ToolSpring& tool) const noexcept override;
    SurfaceAt surface_at(int facet, const Eigen::Vector3d& weight) const noexcept override;
    std::vector<SkinNode> skin_at(const Point& contact_m) const override;
    void show_skin(int facet, const Eigen::Vector3d& weight, double radius_m, const SkinLaw& skin, const Point& push_m, NodeColumns& u) const noexcept override;
    double spacing_m() const override { return surface_.spacing_m(); }

    /// `ground` of a contact there, `inward` into the tissue.
    double ground_at(const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward) const noexcept { return ground_at(contact_m, inward, radius_m_); }

   private:
    struct Disc {
        Eigen::Vector3d normal;
        ContactFactors factors;
        double log_scale;
    };
    /// The contact at a place of the surface; fills the footing. Without means where no tissue is near.
    Disc disc_at(const FreeSurface::Place& place, double radius_m, Footing& footing) const noexcept;
    /// At weights of a facet of the mesh; of a held one at the free place beside it.
    FreeSurface::Place place_of(int facet, const Eigen::Vector3d& weight) const noexcept;

    /// Calls each(SkinNode) for the nodes of a place's skin.
    template <class Each>
    void each_skin_node(const FreeSurface::Place& place, double radius_m, Each&& each) const noexcept;

    bool is_bound() const { return tables_.ball_contact_m > 0; }
    double ground_at(const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward, double radius_m) const noexcept;
    double near_m(double radius_m) const noexcept;  ///< of the nodes that a disc's quadric is fitted to
    SurfaceQuadric quadric_at(const FreeSurface::Place& place, double radius_m) const noexcept;
    double curved_of(const SurfaceQuadric& quadric, double radius_m) const noexcept;
    double correction_at(const FreeSurface::Place& place, double radius_m) const noexcept;

    /// A held facet: the free place nearest to its middle.
    struct Wall {
        Eigen::Index facet = 0;
        Eigen::Vector3d weight{1, 0, 0};
        Eigen::Vector3d inward = Eigen::Vector3d::Zero();
    };

    FreeSurface surface_;
    NodeField rest_;
    std::shared_ptr<const PolarPoints> polar_;
    std::vector<Wall> walls_;              ///< of each facet of the mesh; of free ones as made
    std::vector<std::vector<int>> near_;   ///< of each free facet: surface nodes in near_m of the largest disc of it, ascending
    double radius_m_;
    DiscTables tables_;
    std::vector<bool> fixed_;  ///< (N)
};

}  // namespace tissue
