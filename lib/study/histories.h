#pragma once

#include "study/study.h"
#include "study/toml_reader.h"

namespace tissue {

/// Reads [[histories]] into a study whose loads and draws are read already. Throws StudyError as TomlReader does.
void read_histories(TomlReader& in, Study& study);

}  // namespace tissue
