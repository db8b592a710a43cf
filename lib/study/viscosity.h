#pragma once

#include "study/study.h"
#include "study/toml_reader.h"

namespace tissue {

/// Readers of the keys `viscosity` and `moduli` of a study. All throw StudyError as TomlReader does.

/// Reads `viscosity` and `moduli` of [material], whose material law and moduli are read already, and makes the moduli
/// instantaneous. An empty list means elastic.
/// fe: whether finite elements are to relax. They cannot in plane stress, nor with Ogden's law in space. Without finite
/// elements the relative moduli may be left to a fit to measured histories: then no branch has a g. With "measured" in
/// place of the list the relaxation times are left to the fit too.
void read_viscosity(TomlReader& in, Study::Material& material, bool fe);

/// Reads `viscosity` of a region or the nodule, whose moduli are read already, and makes the moduli instantaneous. The
/// relative moduli are its own or, without the key, the material's; the relaxation times are the material's.
void read_own_viscosity(TomlReader& in, const Study::Material& material, Study::MaterialParameters& own);

}  // namespace tissue
