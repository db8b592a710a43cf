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
#include "train/training_books.h"

namespace tissue {

/// How well one stiffness model does at one load case.
struct CaseError {
    ForceError open_loop{};      ///< not beside a law, which has no Q
    ContactError closed_loop{};
};

/// One column of every table: a way to choose theta, and its errors at the load cases.
struct ModelErrors {
    std::string name;  ///< learned, learned_OPTIMIZER, optimum, one_set, heuristic_a, heuristic_b, uniform
    std::vector<CaseError> cases;

    SpringCharacter springs;
    int lost = 0;  ///< load cases that FE did not reach

    Statistics rel_loss() const;
    Statistics resolved_error() const;
    ContactStatistics closed_loop() const;
};

/// Resolved force against displacement along one load path (Fig. 3).
struct ForceCurve {
    std::string path;
    std::vector<double> magnitude_m, fe_N;
    std::vector<std::string> serving_set;             ///< of the learned model: the nearest trained magnitude
    std::vector<std::vector<double>> model_force_N;   ///< one list a model, in the order of Evaluation::models
};

struct Evaluation {
    std::string study;
    std::vector<std::string> case_names;
    std::vector<double> magnitude_m, fe_resolved_N, smallest_J;  ///< one entry a case
    std::vector<ModelErrors> models;                             ///< learned first
    std::vector<ForceCurve> curves;
    double uniform_N_m;              ///< the uniform model's stiffness
    std::string uniform_chosen_on;   ///< "closed_loop" or, where the mesh has no closed-loop answer at half of the contacts, "rel_loss",
                                     ///< of a law "modulus", the study's E2; in space empty: uniform springs are among the drawn contacts' models alone
    std::vector<TrainingBook> trained;
    OptimumProof optimum;
    std::vector<double> lower_bound_rel;                         ///< one a case: L_lb over sqrt(f_fe' Q f_fe) where (9) alone was minimised;
                                                                 ///< else NaN: L_lb bounds it together with a ridge or the reaction
    ProblemRecord problems;
    std::optional<LawModel> energy_law;                          ///< in place of `trained`, `optimum` and `problems`
    std::optional<LawBook> law_book;
    std::vector<std::string> lost;                               ///< "name: why", training paths that FE ended before their depth
    TruthCheck truth;                                            ///< of FE itself, on the finer mesh
    HeldOut held_out;                                            ///< empty where the study draws no contacts
    TwoTools two_tools;                                          ///< empty where it draws no pairs
    ForceMap map;                                                ///< empty where the study has none
    HistoryTable histories;                                      ///< those held out; empty where the cases have none
    std::optional<Measurement> measurement;                      ///< of measured cases
    bool listed = true;                                          ///< with curves, front and the springs' character
    std::vector<FrontPoint> front;                               ///< loss against distance from the heuristic

    bool open_loop() const { return !energy_law; }  ///< whether the cases' open-loop errors are known
    const ModelErrors& model(const std::string& name) const;
};

constexpr int listed_cases = 100;  ///< load cases up to which each of them is listed

/// Sec. 3 and 5: every trained spring set and every baseline at the load cases they were trained on.
/// Throws MismatchError when model and cases do not belong together, or measured cases are to judge sets.
/// Of a law: its closed loop, and that of the untrained baselines.
/// Curves, the front and what the springs are like are left to sets of up to `listed_cases` load cases.
/// k_min, k_max: the box of the training [N/m], for the front.
Evaluation evaluate(const TrainedModel& model, const Cases& cases, double k_min_N_m, double k_max_N_m, int threads);

/// Which files an evaluation is of, by file_hash; empty: it does not say.
struct EvaluatedFiles {
    std::string model_hash, cases_hash;
};

/// eval.json (results/FORMATS.md).
std::string to_json(const Evaluation& evaluation, unsigned long seed, const EvaluatedFiles& files = {});

/// report.md: for people, the number that matters first.
std::string to_markdown(const Evaluation& evaluation);

}  // namespace tissue
