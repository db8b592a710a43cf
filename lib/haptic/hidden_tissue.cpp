#include "haptic/hidden_tissue.h"

#include <algorithm>

namespace tissue {
namespace {

/// What a session asks of its own model alone is not asked of this one.
HapticOptions alone(HapticOptions options, const TissueModel& truth) {
    options.heuristic_mesh = false;
    options.stiffest = 1;
    options.energy_book = false;
    options.device = {};  // none shows its force
    options.safety.force_max_N = 1e3;
    if (truth.energy_law) options.innovation.reset(), options.coupling_ratio.reset();
    return options;
}

}  // namespace

HiddenTissue::HiddenTissue(std::unique_ptr<Device> hand, const TissueModel& truth, HapticOptions options)
    : hand_(std::move(hand)), model_(truth, alone(std::move(options), truth)), simulation_(model_) {}

DeviceSample HiddenTissue::read(double time_s) noexcept {
    DeviceSample sample = hand_->read(time_s);
    if (reset_.exchange(false, std::memory_order_relaxed) || sample.reset) simulation_.reset();
    // after missed ticks the hand has come farther: that is no jump
    simulation_.tick(sample, last_s_ < time_s ? time_s - last_s_ : 0);
    last_s_ = time_s;
    const TickRecord& tick = simulation_.record();
    sample.measured_N = model_.options.map.force_from_tissue(tick.mesh >= 0 ? Point(-tick.coupling_N) : Point(Point::Zero(model_.dimension())));
    return sample;
}

DeviceSample HiddenTissue::stand_still(double time_s) noexcept {
    const DeviceSample sample = hand_->stand_still(time_s);
    simulation_.stand_still(sample, std::max(0.0, time_s - last_s_));
    last_s_ = time_s;
    return sample;
}

}  // namespace tissue
