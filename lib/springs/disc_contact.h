#pragma once

#include "mesh/free_surface.h"
#include "springs/contact_kernel.h"
#include "springs/disc_tables.h"
#include "springs/polar_points.h"

namespace tissue {

/// Contact of a disc with a tapered imprint on a surface in space, without slip. Under the disc the tissue is displaced
/// by phi(r) d, phi = 1 - (r / R)^2 / 2 within the radius R. The force of the tool is the one conjugate to d.
///
/// Rows, each along the surface's inward normal at the contact and along two tangents:
/// - mean: d - sum_i w_i u_i over points of the surface. The weights sum to 5/4, because the tissue bears 5/4 of the
///   tool's force (springs/polar_points.h).
/// - imprint: phi(r_i) d - u_i at each point within 2.5 R, the shape that the disc imposes. Outside R phi is that of
///   the half space indented by the same parabola, Hertz's (Johnson, Contact Mechanics, (3.42)): (2 - x^2) / pi asin(1
///   / x) + sqrt(x^2 - 1) / pi at x = r / R. Along the surface the displacement of a half space depends on the
///   direction: far away it is proportional to 1 + cos^2 for incompressible tissue (Cerruti; Johnson, (3.75)). The
///   imprint tends to that with 1 - (R / r)^2.
/// The points belong to the disc and have their own weights and shares (springs/polar_points.h). They lie on a quadric
/// over the tangent plane. It is fitted to the surface's nodes within the largest of 2.2 spacings, 2.5 R and the reach
/// of the mean, and farther if these are fewer than 8. Each point moves with the lattice cube that it lies in. Nodes
/// beyond a crease are left out.
///
/// Factors of the place (ContactParameters):
/// - `curved`: R times the mean curvature of the quadric; R / radius on a sphere, negative in a valley. Stiffnesses are
///   exponential in it, so a trained model clamps it to the range of its training contacts.
/// - `ground`: effect of tissue of other stiffness under the disc. To first order in log E / E_block, the force changes
///   by exp of its mean, weighted by the density of the energy that the disc stores. Under a force on an incompressible
///   half space the stress acts along rays alone, as z / r^3 (Boussinesq; Johnson, (3.19)). The weight is thus z^2 /
///   r^6, with R^2 added to r^2:
///   ground = sum_g (8 R / pi^2) z_g^2 / (R^2 + r_g^2)^3 weight_g,
/// which is 1 for a half space with log E / E_block = 1 everywhere.
/// - `edge`: exp(-distance / spacing) from the nearest crease or end of the free surface.
/// All stiffnesses are multiplied by exp(x), with x from DiscTables::correction.
///
/// The contact of a ball (DiscTables::ball_contact_m) is bound: along the surface all of it moves as one, where a
/// disc's displacement tapers off. Its tangential imprint has bound_profile(). Its tangential mean has weights of sum 1
/// in place of 5/4, because the tissue bears exactly the tool's force, and 15/8 of the disc's stiffness: (16/9) E R /
/// (2/3 64/45 E R).
class DiscContact final : public ContactKernel {
   public:
    /// Throws MismatchError for a radius that is not positive, and for a mesh that is not an embedded lattice.
    DiscContact(const SpringMesh& mesh, double radius_m, DiscTables tables = {});

    std::unique_ptr<ContactKernel> clone() const override { return std::make_unique<DiscContact>(*this); }
    ContactRows rows_at(const Point& contact_m) const override;  ///< at the surface point nearest to contact_m
    void tool_at(int facet, const Eigen::Vector3d& weight, double radius_m, const ContactParameters& contact_parameters, ToolSpring& tool) const noexcept override;
    SurfaceAt surface_at(int facet, const Eigen::Vector3d& weight) const noexcept override;
    std::vector<SkinNode> skin_at(const Point& contact_m) const override;
    void show_skin(int facet, const Eigen::Vector3d& weight, double radius_m, const SkinParameters& skin, const Point& push_m, NodeColumns& u) const noexcept override;
    double spacing_m() const override { return surface_.spacing_m(); }

    /// Factor `ground` of a contact at contact_m [m]. inward: unit normal into the tissue.
    double ground_at(const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward) const noexcept { return ground_at(contact_m, inward, radius_m_); }

   private:
    struct Disc {
        Eigen::Vector3d normal;
        ContactFactors factors;
        double log_scale;
    };
    /// The contact at a place of the surface; fills `footing`. Footing::means is 0 where there is no tissue nearby.
    Disc disc_at(const FreeSurface::Place& place, double radius_m, Footing& footing) const noexcept;
    /// Place at weights of a facet of the mesh; for a fixed facet its Wall's place.
    FreeSurface::Place place_of(int facet, const Eigen::Vector3d& weight) const noexcept;

    /// Calls each(SkinNode) for the skin nodes of the contact at a place.
    template <class Each>
    void each_skin_node(const FreeSurface::Place& place, double radius_m, Each&& each) const noexcept;

    bool is_bound() const { return tables_.ball_contact_m > 0; }
    double ground_at(const Eigen::Vector3d& contact_m, const Eigen::Vector3d& inward, double radius_m) const noexcept;
    double near_m(double radius_m) const noexcept;  ///< radius within which a disc's quadric is fitted [m]
    SurfaceQuadric quadric_at(const FreeSurface::Place& place, double radius_m) const noexcept;
    double curved_of(const SurfaceQuadric& quadric, double radius_m) const noexcept;
    double correction_at(const FreeSurface::Place& place, double radius_m) const noexcept;

    /// For a fixed facet: the place of the free surface nearest to its middle, and its own inward normal.
    struct Wall {
        Eigen::Index facet = 0;
        Eigen::Vector3d weight{1, 0, 0};
        Eigen::Vector3d inward = Eigen::Vector3d::Zero();
    };

    FreeSurface surface_;
    NodeField rest_;
    std::shared_ptr<const PolarPoints> polar_;
    std::vector<Wall> walls_;              ///< one per facet of the mesh; default values for free ones
    /// per free facet: surface nodes within near_m of any of its points, for the largest contact; ascending
    std::vector<std::vector<int>> near_;
    double radius_m_;
    DiscTables tables_;
    std::vector<bool> fixed_;  ///< (N)
};

}  // namespace tissue
