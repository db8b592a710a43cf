#pragma once

#include "springs/tissue_model.h"

namespace tissue {

/// A law in memory on any mesh in space, under a disc of 7 mm: each constant another, so that none can stand in for another. No FE in it.
TissueModel solid_law_example(const SpringMesh& mesh);

}  // namespace tissue
