#pragma once

#include <limits>
#include <string>

#include "study/study.h"
#include "study/toml_reader.h"

namespace tissue {

/// Readers of the parts of a study that are alike in the plane and in space. All throw StudyError as TomlReader does.

constexpr Range positive{0, std::numeric_limits<double>::infinity(), true};
constexpr Range not_negative{0};

/// Path of an existing file `name`, relative to the folder of the file that contains `key`. Where it does not exist,
/// the message refers to a README.md in its folder that has its name.
std::string file_beside(const TomlReader& in, const std::string& key, const std::string& name);

bool is_multiple(double value, double step);

/// Lower-case letters, digits and '-', one at least.
bool is_plain_name(const std::string& name);

/// law: the material law. terms: number of terms that Ogden's law must have; 0: any number.
Study::MaterialParameters read_material_parameters(TomlReader& in, const std::string& law, std::size_t terms = 0);

/// magnitudes_m and record_step_m of [loads]. No magnitude may be larger than the longest side of a block.
Study::Loads read_magnitudes(TomlReader& in, const Study::Geometry& geometry);

Study::Solver read_solver(TomlReader solver);

/// Keys of one role of [draws].
void read_seed_and_count(TomlReader& draw, Study::Draws& d);
void read_depth(TomlReader& draw, const Study& study, Study::Draws& d);
/// Appends `d` to the study's draws. Refuses keys that were not read, and a seed that another role has.
void add_draws(const TomlReader& draw, const Study::Draws& d, Study& study);

}  // namespace tissue
