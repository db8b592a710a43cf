#pragma once

#include <memory>

#include "error.h"
#include "springs/contact_kernel.h"
#include "springs/equilibrium.h"
#include "springs/tissue_model.h"

namespace tissue {

/// The ball's contact is larger than the energy model supports.
class ContactTooLargeError : public MismatchError {
   public:
    using MismatchError::MismatchError;
};

/// Indentation of a model in space by a rigid ball, without slip. The model must have been trained under discs of
/// several radii (springs/energy_model_at_radius.h). Where Hertz's contact has the radius a, the tissue under the ball has the
/// disc's displacement u = (1 - (r / a)^2 / 2) d (springs/disc_contact.h). A ball at the depth d is therefore the disc
/// of radius a(d), and the stored energy is E(a(d), d). The force is the derivative along that path,
///   F = dE/dd + dE/da a'(d_n) inward,   d_n: component of d along the inward normal.
/// On a half space F is 5/4 of dE/dd: the resultant of Hertz's pressure instead of the force conjugate to the disc's d.
///
/// a(d_n) is that of BallContact. It uses the surface's curvature around the contact of a ball that is half in the
/// tissue. Deeper indentations are refused.
///
/// Along the surface each ring of the contact is bound where it forms (springs/bound_rings.h). On a half space dQ =
/// (16/9) E a dd_t (Mindlin 1949, incompressible), as for a flat punch bound to the tissue. On a straight path this
/// stretches the contact's spring by BallContact::bound_part of d_t.
///
/// Under an oblique displacement the contact stays where the ball first touched, and the ball does not roll.
class BallIndentation {
   public:
    /// radius_m: radius of the ball [m]. Throws MismatchError for a radius that is not positive and finite, for a model
    /// without a disc, and for one that was trained under one disc radius.
    BallIndentation(const SpringMesh& mesh, EnergyModel energy_model, double radius_m);

    /// Radius of the contact [m] at a tool displacement push_m [m] (D); 0 where it points out of the tissue.
    double contact_radius_m(const Point& contact_m, const Point& push_m) const;

    /// Equilibrium from rest, as IndentationSolver::at, with the displacement as it is displayed (IndentationSolver::displayed). It is the
    /// rest state where push_m does not point into the tissue. For contacts smaller than the smallest trained disc the
    /// stiffnesses follow their analytical start (springs/patch_sizes.h). Throws ContactTooLargeError where the contact
    /// is larger than the largest trained disc, or where more than half of the ball is in the tissue.
    Equilibrium at(const Point& contact_m, const Point& push_m) const;

   private:
    struct Place {
        Eigen::Vector3d inward;
        double radius_m;  ///< effective radius R_e
    };
    Place place_at(const Point& contact_m) const;
    double contact_radius_m(const Place& place, const Point& push_m) const;

    SpringMesh mesh_;
    EnergyModel law_;
    double radius_m_;
    /// contact of the half-immersed ball: gives the surface's normal and curvature
    std::shared_ptr<const ContactKernel> kernel_;
};

}  // namespace tissue
