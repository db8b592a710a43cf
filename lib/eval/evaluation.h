#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "eval/closed_loop.h"
#include "eval/force_error.h"
#include "eval/force_map.h"
#include "eval/held_out.h"
#include "eval/history_answers.h"
#include "eval/spring_character.h"
#include "eval/two_tools.h"
#include "train/training_diagnostics.h"

namespace tissue {

/// Errors of one model at one load case.
struct CaseError {
    ForceError open_loop{};      ///< not set where the study has an energy model, whose training has no Q
    ContactError closed_loop{};
};

/// One model (the trained one or a baseline) and its errors at the load cases.
struct ModelErrors {
    std::string name;  ///< learned, learned_OPTIMIZER, optimum, one_set, heuristic_a, heuristic_b, uniform
    std::vector<CaseError> cases;

    SpringCharacter springs;
    int lost = 0;  ///< load cases without an FE reference

    Statistics rel_loss() const;
    Statistics resolved_error() const;
    ContactStatistics closed_loop() const;
};

/// Resolved force against tool displacement along one load path (Fig. 3).
struct ForceCurve {
    std::string path;
    std::vector<double> magnitude_m, fe_N;
    std::vector<std::string> serving_set;             ///< set of the nearest trained magnitude
    std::vector<std::vector<double>> model_force_N;   ///< (models x magnitudes), in the order of Evaluation::models
};

struct Evaluation {
    std::string study;
    std::vector<std::string> case_names;
    std::vector<double> magnitude_m, fe_resolved_N, smallest_J;  ///< of each case (C)
    std::vector<ModelErrors> models;                             ///< the trained one first
    std::vector<ForceCurve> curves;
    double uniform_N_m;              ///< stiffness of the uniform baseline [N/m]; 0 in space
    /// How uniform_N_m was chosen. "closed_loop": smallest median indentation error of force. Where half of the
    /// contacts have no equilibrium: "rel_loss", the smallest median nodal-force error, or "modulus", the study's E2,
    /// if the study has an energy model. Empty in space, where only drawn contacts have a uniform baseline.
    std::string uniform_chosen_on;
    std::vector<SetDiagnostics> trained;
    OptimumCertificate optimum;
    /// L_lb over sqrt(f_fe' Q f_fe) of each case (C) where (9) alone was minimised. NaN where the minimised function
    /// also has a ridge or the reaction: L_lb is then a bound of the sum.
    std::vector<double> lower_bound_rel;
    ProblemRecord problems;
    std::optional<EnergyModel> energy_model;                          ///< in place of `trained`, `optimum` and `problems`
    std::optional<EnergyModelDiagnostics> energy_model_diagnostics;
    std::vector<std::string> lost;                               ///< "name: why", training paths that end early in FE
    DiscretisationCheck discretisation;                                            ///< discretisation error of the FE reference
    HeldOut held_out;                                            ///< empty where the study draws no contacts
    TwoTools two_tools;                                          ///< empty where the study draws no pairs of tools
    ForceMap map;                                                ///< empty where the study has no map
    HistoryTable histories;                                      ///< of the test set; empty where the cases have none
    std::optional<Measurement> measurement;                      ///< of measured cases
    bool listed = true;                                          ///< whether curves, front and springs are evaluated
    std::vector<FrontPoint> front;                               ///< loss against distance from the heuristic

    bool open_loop() const { return !energy_model; }  ///< whether the cases have nodal-force errors
    const ModelErrors& model(const std::string& name) const;
};

constexpr int listed_cases = 100;  ///< with more load cases they are not listed one by one

/// Evaluates the trained model and all baselines at the training load cases (Sec. 3 and 5) and at the drawn contacts.
/// Spring sets have nodal-force and indentation errors; an energy model has indentation errors only. Curves, front and
/// spring character are evaluated for spring sets with at most `listed_cases` load cases.
/// k_min_N_m, k_max_N_m: box of the training [N/m], used by the front. threads: without influence on the result.
/// Throws MismatchError when the model was not trained on these cases, and for spring sets with measured cases.
Evaluation evaluate(const TrainedModel& model, const Cases& cases, double k_min_N_m, double k_max_N_m, int threads);

/// Hashes (file_hash) of the evaluated model and cases files; empty: not written.
struct EvaluatedFiles {
    std::string model_hash, cases_hash;
};

/// Text of eval.json (results/FORMATS.md). seed: of the training.
std::string to_json(const Evaluation& evaluation, unsigned long seed, const EvaluatedFiles& files = {});

/// Text of report.md. Its first line is the main result.
std::string to_markdown(const Evaluation& evaluation);

}  // namespace tissue
