#pragma once

#include "study/study.h"
#include "study/toml_reader.h"

namespace tissue {

/// Tissue that relaxes: keys `viscosity` and `moduli` of a study. All refuse as TomlReader does.

/// `viscosity` and `moduli` of [material], whose law and moduli are read already; makes these instantaneous. An empty list is elastic.
/// fe: whether finite elements are to relax: those of plane stress, and of Ogden's law in space, cannot. Where there are none, shares may be left to
/// measured histories: no g in any branch, or "measured" in place of the list, which leaves the times to them too.
void read_viscosity(TomlReader& in, Study::Material& material, bool fe);

/// `viscosity` of a region or the nodule, whose moduli are read already: shares of its own, of the material's times, or the material's
/// shares. Makes the moduli instantaneous.
void read_own_viscosity(TomlReader& in, const Study::Material& material, Study::LawParameters& own);

}  // namespace tissue
