#pragma once

#include "haptic/realtime_mesh.h"
#include "springs/tissue_model.h"

namespace tissue {

/// How fast a law's tissue can swing [1/s^2]: squared angular frequencies, of M^-1 K.
struct LawSpectrum {
    double smallest;  ///< at rest, untouched
    double largest;   ///< at rest, touched and pressed, the contact's springs included; no number when any of them is none
    double contact_N_m;  ///< the most that a contact answers a hand with at once, before the tissue under it moves: at rest and pressed [N/m]
    double static_N_m = 0;   ///< the most that a tool's force is over its push in these presses, everything at rest [N/m]: a secant
};

/// The largest over presses as deep as the deepest load case. In the plane straight in and 45 degrees to either side, at places
/// spread evenly over the free surface and at its corners. In space a press takes a tenth of a second: straight in and 30 degrees
/// off, at four places: where the contact itself swings fastest, and three as far apart as the surface has them. With more than
/// 1,500 nodes that have mass a press takes seconds; then only the first place is pressed. Of a press whose rest is lost it is as far as it came.
/// springs: of the model's mesh. tools: so many contacts may lie at one place, which then swings faster. Throws MismatchError for a model without a law.
LawSpectrum law_spectrum(const TissueModel& model, const RealtimeMesh& springs, int tools = 1);

}  // namespace tissue
