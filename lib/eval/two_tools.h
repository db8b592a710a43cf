#pragma once

#include <array>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "eval/closed_loop.h"
#include "train/training_books.h"

namespace tissue {

/// Two discs pushed at once on one body, at the depths that were drawn, and how far each model is from the force on each.
struct PressedPair {
    std::string name;
    std::array<Point, 2> contact_m, push_m, fe_force_N;    ///< of the first and the second tool (3)
    double radius_m;                                       ///< of both discs
    std::vector<std::array<ContactError, 2>> error = {};   ///< of each model, on the first and the second tool; force alone

    double apart_m() const { return (contact_m[0] - contact_m[1]).norm(); }  ///< middles, at rest
};

/// One role of drawn pairs.
struct PressedPairs {
    std::string role;
    std::vector<PressedPair> pairs;
    std::vector<std::string> lost;                         ///< "name: why", pairs at which FE has no answer

    ContactStatistics statistics(std::size_t model) const; ///< over tools: two errors a pair, lost ones included
};

struct TwoTools {
    std::vector<std::string> models;
    std::vector<PressedPairs> roles;

    bool empty() const { return roles.empty(); }
};

/// Force errors at every pair of the cases, in closed loop:
///   learned  the law, pressed by both tools at once
///   alone    the law, pressed by each tool as if the other were not there: what the forces are without their interaction
/// Empty where the cases have no pairs, or the model has no law.
TwoTools evaluate_two_tools(const TrainedModel& model, const Cases& cases, int threads);

}  // namespace tissue
