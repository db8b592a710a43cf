#pragma once

#include "mesh/free_surface.h"
#include "springs/contact_kernel.h"

namespace tissue {

/// Contact of a tapered disc on a surface in space: under it the tissue follows phi(r) d, phi = 1 - (r / R)^2 / 2 within its
/// radius R, without slip; the force that a hand feels is the one conjugate to d. Rows, all along the surface's inward
/// normal at the contact and along two tangents:
///   mean     d - sum_i w_i u_i, w the moving-least-squares weights of the surface's nodes within 1.6 spacings, which
///            sum to 1 and reproduce linear fields whatever the surface's mesh (Lancaster and Salkauskas 1981, Mathematics
///            of Computation 37: 141-158)
///   imprint  phi(r_i) d - u_i of every node within 2 R, times (1 - (r_i / 2R)^2)^2: the shape that the disc presses in.
///            Outside R phi is that of the half space which the same parabola is pressed into, Hertz's (Johnson, Contact
///            Mechanics, (3.42)): (2 - x^2) / pi asin(1 / x) + sqrt(x^2 - 1) / pi at x = r / R. Along the surface a half space
///            follows a force the more where it points to, (1 + cos^2) for incompressible tissue far away (Cerruti; Johnson,
///            (3.75)), and the imprint goes over to that with 1 - (R / r)^2
/// Where between the nodes it stands is `phase`: how far the nodes crowd there, as a sum of Gaussian bells of 0.35 spacings
/// about them, over its mean; scaled so that on a square lattice it is cos 2 pi x + cos 2 pi y over 2, to a tenth. On a shape, whose
/// nodes do not lie equally dense, each counts as the part of the surface that it carries.
/// Nodes round a crease do not belong to it.
class DiscContact final : public ContactKernel {
   public:
    /// Throws MismatchError for a radius that is not positive.
    DiscContact(const SpringMesh& mesh, double radius_m);

    ContactRows rows_at(const Point& contact_m) const override;  ///< at the surface's point nearest to that
    double spacing_m() const override { return surface_.spacing_m(); }

    /// phi at r / R.
    static double profile(double x);

   private:
    FreeSurface surface_;
    NodeField rest_;
    double radius_m_;
    Eigen::VectorXd carried_;  ///< part of the free surface that a node carries, in squared spacings: 1 on a lattice (N)
};

}  // namespace tissue
