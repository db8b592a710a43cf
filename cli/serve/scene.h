#pragma once

#include <string>
#include <utility>
#include <vector>

#include "fe_outline.h"
#include "haptic/state_channel.h"
#include "springs/tissue_model.h"

namespace tissue::serve {

/// One place where the model knows finite elements' answer: its load cases with one contact and one direction.
struct Place {
    std::string name;
    Eigen::Vector2d contact_m, direction, inward;  ///< learned mesh at rest; unit vectors
    double depth_m = 0;                            ///< deepest case
    std::vector<std::pair<double, double>> curve;  ///< depth [m], FE force along the push [N], from 0; or empty
    std::vector<FeOutline> outlines;               ///< FE's surface by depth, from rest; or empty
};

/// The known place that is nearest to a contact.
struct Near {
    int place = -1;
    double distance_m = 0;
    double force_N;         ///< FE's at the learned mesh's depth, along the push; NaN when unknown
};

/// What a model looks like to a page, and to the hand that presses it. Constants only.
class Scene {
   public:
    /// fe_displacement_m: FE's, of every node at each load case (C) of (N x D), or empty.
    Scene(const TissueModel& tissue, const HapticModel& model, const std::vector<NodeField>& fe_displacement_m = {});

    const std::vector<Place>& places() const { return places_; }
    int first_place() const { return first_; }     ///< where the demo begins: the middle of the top, straight in
    const HapticModel& model() const { return model_; }

    /// Boxes [low, high] of every mesh at rest, in the plane.
    const std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>& boxes() const { return boxes_; }

    Near near(const TickState& state) const;

    /// The message of type `model` (cli/view/PROTOCOL.md). names: of all models served; index: of this one.
    std::string message(const std::vector<std::string>& names, int index) const;

   private:
    const HapticModel& model_;
    std::vector<int> fixed_;
    Eigen::Matrix<int, Eigen::Dynamic, 2> springs_;
    std::vector<Place> places_;
    std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> boxes_;
    int first_ = 0;
};

/// One state as the page gets it (cli/view/PROTOCOL.md): 32 float64 and the nodes' float32, little-endian.
struct TickSummary {
    double ticks_a_second = 0, p50_us = 0, p99_us = 0;
    long long faults = 0, clients = 0;
    long long ticks = 0, misses = 0, misses_program = 0, clamped = 0;
};
std::string encode_state(const TickState& state, const HapticModel& model, const Near& near, const TickSummary& summary);

}  // namespace tissue::serve
