#pragma once

#include "study/study.h"
#include "study/toml_reader.h"

namespace tissue {

/// [[histories]] of a study whose loads and draws are read already. Refuses as TomlReader does.
void read_histories(TomlReader& in, Study& study);

}  // namespace tissue
