#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/held_out.h"
#include "study/study.h"

namespace tissue {

/// One variant of a study's law, trained on what it keeps and tried on the study's drawn contacts.
struct VariantResult {
    Study::Variant variant;
    int fe_paths;      ///< FE solves its training contacts need; mirrored ones count once
    int records;       ///< pushes along them
    double seconds;    ///< wall time of its training
    double objective;  ///< train/train_law.h, at the end
    std::vector<std::string> broken;  ///< what of it did not end as it promises, train/endings.h
    HeldOut held_out;
    bool seen_inside;  ///< whether shapes are known: not of measured cases
};

/// Trains and tries every variant of the study (fem/studies/NAME.toml, [[variants]]), the study itself first.
std::vector<VariantResult> ablate(const Study& study, const Cases& cases, int threads,
                                  const std::function<void(int done, int total, const std::string& name)>& progress = {});

/// ablation.json (results/FORMATS.md).
std::string to_json(const std::vector<VariantResult>& results);

}  // namespace tissue
