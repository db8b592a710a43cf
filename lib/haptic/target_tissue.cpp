#include "haptic/target_tissue.h"

#include <algorithm>

namespace tissue {
namespace {

/// Options for the target tissue: without those that concern the session's own model and device.
HapticOptions alone(HapticOptions options, const TissueModel& target) {
    options.heuristic_mesh = false;
    options.stiffest = 1;
    options.energy_book = false;
    options.tools = 1;
    options.tool.resize(1);
    options.device = {};  // no device gets its force
    options.safety.force_max_N = 1e3;
    if (target.energy_model) options.innovation.reset(), options.coupling_ratio.reset();
    return options;
}

}  // namespace

TargetTissue::TargetTissue(std::unique_ptr<Device> hand, const TissueModel& target, HapticOptions options)
    : hand_(std::move(hand)), model_(target, alone(std::move(options), target)), simulation_(model_) {}

DeviceSample TargetTissue::read(double time_s) noexcept {
    DeviceSample sample = hand_->read(time_s);
    if (reset_.exchange(false, std::memory_order_relaxed) || sample.reset) simulation_.reset();
    // the time that really passed: after missed ticks the hand has moved farther, which is no jump
    simulation_.tick(sample, last_s_ < time_s ? time_s - last_s_ : 0);
    last_s_ = time_s;
    const TickRecord& tick = simulation_.record();
    sample.measured_N = model_.options.map.force_from_tissue(tick.mesh >= 0 ? Point(-tick.coupling_N) : Point(Point::Zero(model_.dimension())));
    return sample;
}

DeviceSample TargetTissue::skip_tick(double time_s) noexcept {
    const DeviceSample sample = hand_->skip_tick(time_s);
    simulation_.skip_tick(sample, std::max(0.0, time_s - last_s_));
    last_s_ = time_s;
    return sample;
}

}  // namespace tissue
