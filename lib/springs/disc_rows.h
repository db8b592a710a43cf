#pragma once

#include "springs/contact_patch.h"

namespace tissue {

/// Logarithms of a disc's contact parameters before training, in the order of ContactParameters::disc_rows: normal, tangent,
/// imprint_normal, imprint_tangent [N/m], hardening, saturation [1/J], coupling [N/m^2]. radius_m: disc radius R > 0;
/// spacing_m: cube edge h > 0 of the lattice. NaN for other values.
///
/// The first four are derived. The rows are in series with the lattice, here a half space of isotropic springs whose
/// cells have 0.95 of a cap of 12 E, as before training (start_below_cap, springs/energy_model_terms.h). Together they
/// have the stiffness of incompressible linear elasticity: along the normal 64/45 E R, of the force conjugate to d
/// under Hertz's pressure; along the surface 2/3 of that, under a traction of the same profile. The mean rows bear 0.55
/// of the normal force and 0.36 of the tangential one; the imprint rows bear the rest. The compliance that the lattice
/// has depends on R / h and is 0 at R / h = 0, so that of the rows depends on R / h too, and is largest there.
///
/// They are fitted within 0.6 % to the compliances of the contact of springs/polar_points.h at R / h = 0.25, 0.5, 0.75,
/// 1, 1.0667, 1.25, 1.5, 2 and 2.5. These are means over 8 places in a cube: four along the surface, which is a lattice
/// plane or half way between two. The blocks are 14 and 20 edges wide and half as deep; the effect of their floor and
/// sides, which is proportional to 1 / size, is subtracted. At R / h = 0 the fit is exact. Beyond R / h = 2.5 the first
/// four rows grow in proportion to the radius.
///
/// The last three were chosen on validation contacts of block3-quick (R / h = 0.7: 0.59 / (E R^3), 0.073 / (E R^3) and
/// 0.78 E). They are scaled with the stiffnesses of the mean rows. At any R / h the same force in E R^2 thus hardens
/// the contact equally, and the same tangential force causes the same normal force.
ContactParameters::Start start_of_disc(double modulus_Pa, double radius_m, double spacing_m) noexcept;

}  // namespace tissue
