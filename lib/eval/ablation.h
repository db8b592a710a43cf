#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/held_out.h"
#include "study/study.h"

namespace tissue {

/// One variant of a study's energy model: trained on its load cases, evaluated on the study's drawn contacts.
struct VariantResult {
    Study::Variant variant;
    int fe_paths;      ///< FE load paths that its training needs; mirror images are not counted
    int records;       ///< load cases along these paths
    double seconds;    ///< wall time of the training
    double objective;  ///< TrainedEnergyModel::objective at the end of the training (train/train_energy_model.h)
    /// Parts of the training that did not converge (Endings::broken, train/endings.h).
    std::vector<std::string> broken;
    HeldOut held_out;
    bool seen_inside;  ///< whether reference displacements are known; false for measured cases
};

/// Trains and evaluates every variant of the study (fem/studies/NAME.toml, [[variants]]). The first result is the study
/// itself. threads: number of threads, without influence on the results. progress: called after each variant.
std::vector<VariantResult> ablate(const Study& study, const Cases& cases, int threads,
                                  const std::function<void(int done, int total, const std::string& name)>& progress = {});

/// Text of ablation.json (results/FORMATS.md).
std::string to_json(const std::vector<VariantResult>& results);

}  // namespace tissue
