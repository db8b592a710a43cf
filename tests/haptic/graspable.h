#pragma once

#include "../example.h"

namespace tissue {

/// solid_example() with a contact that hardens in compression alone, which a tool may grasp.
inline TissueModel graspable_solid() {
    TissueModel tissue = solid_example();
    for (std::string& term : tissue.energy_model->terms)
        if (term == "contact.hardening") term = "contact.compression";
    tissue.energy_model->patch.curve = ContactCurve::compression;
    return tissue;
}

}  // namespace tissue
