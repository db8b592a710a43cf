#pragma once

#include <memory>

#include "error.h"
#include "springs/contact_kernel.h"
#include "springs/equilibrium.h"
#include "springs/tissue_model.h"

namespace tissue {

/// A ball is deeper than its law can say.
class ContactTooLargeError : public MismatchError {
   public:
    using MismatchError::MismatchError;
};

/// A rigid ball pressed into a model in space that was trained under discs of several radii (springs/law_at_radius.h). Where Hertz's contact has the radius a, the tissue under the ball follows that of the disc,
/// u = (1 - (r / a)^2 / 2) d (springs/disc_contact.h): a ball at the depth d is the disc of radius a(d), and what is stored is E(a(d), d). Its force is the derivative along that way,
///   F = dE/dd + dE/da a'(d_n) inward,   d_n the part of d along the inward normal,
/// on a half space 5/4 of the first part alone: the resultant of Hertz's pressure, not what is conjugate to the disc's d. a(d_n) is BallContact's, whose curvature of the surface is that about the contact of
/// a ball that is half in; deeper ones are refused. Without slip. Along the surface each ring of the contact is bound
/// where it begins (springs/bound_rings.h), dQ = (16/9) E a dd_t on a half space (Mindlin 1949, incompressible), as that of a flat punch bound to the tissue: on a straight way that stretches the contact's spring by
/// BallContact::bound_part of d_t. Of an oblique displacement the contact stays where it first touched, and the ball does not roll.
class BallPress {
   public:
    /// Throws MismatchError for a radius [m] that is not positive, and for a law that has no disc or knows only its own.
    BallPress(const SpringMesh& mesh, LawModel law, double radius_m);

    /// Radius of the contact where the ball is pushed there by d [m]; 0 where it is drawn away.
    double contact_radius_m(const Point& contact_m, const Point& push_m) const;

    /// From rest, as LawPress::at, with the displacement as it is seen (LawPress::seen). Below the smallest disc that the law knows its contact's rows go on as they start (springs/patch_sizes.h). Throws ContactTooLargeError where the contact is larger than the largest one,
    /// or the ball more than half in.
    Equilibrium at(const Point& contact_m, const Point& push_m) const;

   private:
    struct Place {
        Eigen::Vector3d inward;
        double radius_m;  ///< R_e
    };
    Place place_at(const Point& contact_m) const;
    double contact_radius_m(const Place& place, const Point& push_m) const;

    SpringMesh mesh_;
    LawModel law_;
    double radius_m_;
    std::shared_ptr<const ContactKernel> kernel_;  ///< of the contact where half of it is in: where the surface is, and how curved
};

}  // namespace tissue
