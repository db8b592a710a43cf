#pragma once

#include "study/study.h"
#include "study/toml_reader.h"

namespace tissue {

/// Reads [indenter], [mesh], [nodule], [solver], [loads] and [map] of a solid block or shape.
void read_solid_fe(TomlReader& in, Study& study);

/// Reads tilt_deg and clearance_m of contacts drawn in space.
void read_solid_place(TomlReader& draw, const Study& study, Study::Draws& d);

/// Reads [draws] in space: validation, held_out and held_out_WORD.
void read_solid_draws(TomlReader in, Study& study);

/// Whether load paths of this role may have two discs at once: held_out_WORD, but not held_out_full, because its
/// readers expect single contacts.
bool is_role_of_pairs(const std::string& role);

}  // namespace tissue
