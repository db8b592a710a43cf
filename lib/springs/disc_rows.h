#pragma once

#include "springs/contact_patch.h"

namespace tissue {

/// A disc's rows before anything is learned (PatchLaw::disc_rows: normal, tangent, imprint_normal, imprint_tangent [N/m], hardening, saturation [1/J], coupling [N/m^2]), as logarithms; radius and
/// edge h of the lattice's cubes above 0 (NaN else).
/// The first four are derived: in series with a half space of isotropic springs and cells (springs/energy_law.h, cells at 0.95 of a cap of 12 E) they give what linear elasticity does for incompressible
/// tissue. That is 64/45 E R straight in, the force conjugate to d under Hertz's pressure, and 2/3 of it along the surface, of a traction that falls off likewise. The mean rows bear 0.55 of the force
/// straight in and 0.36 along, the imprint the rest. So rows depend on R / h: the smaller a disc is, the less the lattice gives way under it, down to none, and the more the rows do. Fitted within 0.6 %
/// to the compliances of springs/polar_points.h at R / h of 0.25, 0.5, 0.75, 1, 1.0667, 1.25, 1.5, 2 and 2.5, means over 8 places of a cube (four along the surface, which is a plane of the lattice
/// or half way between two), on blocks 14 and 20 edges wide and half as deep, less what their floor and sides are worth, which goes with 1 / size; at R / h = 0 they are exact. Beyond 2.5 the first
/// four grow with the radius.
/// The last three were chosen on validation contacts of block3-quick (R / h = 0.7: 0.59 / (E R^3), 0.073 / (E R^3) and 0.78 E) and go by what the mean rows give way, so that at any R / h the same force
/// in E R^2 hardens as much, and the same force along the surface presses back as much.
PatchLaw::Start start_of_disc(double modulus_Pa, double radius_m, double spacing_m) noexcept;

}  // namespace tissue
