#pragma once

#include "haptic/realtime_mesh.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Extreme eigenvalues of M^-1 K of an energy model's tissue (squared angular frequencies), and stiffnesses of its
/// contact.
struct EnergyModelSpectrum {
    double smallest;  ///< of the tissue at rest without a tool [1/s^2]
    double largest;   ///< over all states of energy_model_spectrum(), contacts included [1/s^2]; NaN when one is NaN
    double contact_N_m;  ///< largest stiffness of a contact in any direction while the nodes do not move, at rest and indented [N/m]
    double static_N_m = 0;  ///< largest force over tool displacement in equilibrium (secant) [N/m]
};

/// The spectrum at rest, with a contact at rest, and in indentations to the depth of the deepest load case.
///
/// In the plane the tool goes straight in and 45 degrees to either side. The places are spread evenly over the free
/// surface, and its corners are added.
/// In space the tool goes straight in and 30 degrees off, at four places: the one where the contact by itself has the
/// highest frequency, and three as far apart as possible. There an indentation takes a tenth of a second to compute.
/// With more than 1,500 nodes that have mass it takes seconds, and only the first place is used.
/// An indentation that finds no equilibrium counts as far as it came.
///
/// springs: mesh of the model. tools: number of contacts that may act at one place, which raises `largest`. Throws
/// MismatchError for a model that is no energy model.
EnergyModelSpectrum energy_model_spectrum(const TissueModel& model, const RealtimeMesh& springs, int tools = 1);

}  // namespace tissue
