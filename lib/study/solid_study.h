#pragma once

#include "study/study.h"
#include "study/toml_reader.h"

namespace tissue {

/// What finite elements need in space: [indenter], [mesh], [nodule], [solver] and [loads], of a block or of a shape.
void read_solid_fe(TomlReader& in, Study& study);

/// tilt_deg and clearance_m of contacts drawn in space.
void read_solid_place(TomlReader& draw, const Study& study, Study::Draws& d);

/// [draws] in space: validation, held_out and held_out_WORD.
void read_solid_draws(TomlReader in, Study& study);

/// Whether load paths of this role may be of two discs at once: held_out_WORD, but not held_out_full, which single contacts alone are looked for in.
bool is_role_of_pairs(const std::string& role);

}  // namespace tissue
