#pragma once

#include <array>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "eval/closed_loop.h"
#include "train/training_diagnostics.h"

namespace tissue {

/// Two discs that indent one body at once, at drawn depths, and the force errors of each model on both discs.
struct IndentationPair {
    std::string name;
    std::array<Point, 2> contact_m, push_m, fe_force_N;    ///< of the first and the second tool (3)
    double radius_m;                                       ///< of both discs
    /// Of each model, on the first and the second tool; force only.
    std::vector<std::array<ContactError, 2>> error = {};

    double apart_m() const { return (contact_m[0] - contact_m[1]).norm(); }  ///< distance of the centres at rest
};

/// Drawn pairs of one role (training, validation or test set).
struct IndentationPairs {
    std::string role;
    std::vector<IndentationPair> pairs;
    std::vector<std::string> lost;                         ///< "name: why", pairs without an FE reference

    ContactStatistics statistics(std::size_t model) const; ///< over tools: two errors for each pair; `lost` pairs count
};

struct TwoTools {
    std::vector<std::string> models;
    std::vector<IndentationPairs> roles;

    bool empty() const { return roles.empty(); }
};

/// Indentation errors of force at every pair of tools of the cases. Models:
///   learned  the energy model with both tools at once
///   alone    the energy model with each tool by itself: shows how large the interaction of the tools is
/// threads: without influence on the result. Empty where the cases have no pairs, or the model has no energy model.
TwoTools evaluate_two_tools(const TrainedModel& model, const Cases& cases, int threads);

}  // namespace tissue
