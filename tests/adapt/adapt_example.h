#pragma once

#include <vector>

#include "adapt/adaptation.h"

namespace tissue {

/// Pokes of a law, without noise: straight and tilted pushes of 3 to 8 mm round the block of law_example, in an order that jumps about.
std::vector<Poke> pokes_of(const TissueModel& truth, int count, unsigned long seed = 1);

/// |model - reading| / |reading|, the largest over pokes.
double worst_error(const TissueModel& model, const std::vector<Poke>& pokes);

/// A law stiffer by exp(log_stiffness) all over, its contacts too.
TissueModel stiffer(TissueModel model, double log_stiffness);

}  // namespace tissue
