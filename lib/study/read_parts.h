#pragma once

#include <limits>
#include <string>

#include "study/study.h"
#include "study/toml_reader.h"

namespace tissue {

/// Parts of a study that are read alike in the plane and in space. All refuse as TomlReader does.

constexpr Range positive{0, std::numeric_limits<double>::infinity(), true};
constexpr Range not_negative{0};

/// A file that has to be there, beside the one in which the key stands. A README.md beside it that has its name is pointed to.
std::string file_beside(const TomlReader& in, const std::string& key, const std::string& name);

bool is_multiple(double value, double step);

/// Lower-case letters, digits and '-', one at least.
bool is_plain_name(const std::string& name);

/// terms: of an Ogden law that the entries must be as many as; 0: any number.
Study::LawParameters read_law_parameters(TomlReader& in, const std::string& law, std::size_t terms = 0);

/// magnitudes_m and record_step_m of [loads], no longer than a block.
Study::Loads read_magnitudes(TomlReader& in, const Study::Geometry& geometry);

Study::Solver read_solver(TomlReader solver);

/// Of one role of [draws].
void read_seed_and_count(TomlReader& draw, Study::Draws& d);
void read_depth(TomlReader& draw, const Study& study, Study::Draws& d);
/// Puts it among the study's draws, none of which has its seed.
void add_draws(const TomlReader& draw, const Study::Draws& d, Study& study);

}  // namespace tissue
