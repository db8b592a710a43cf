#pragma once

#include <atomic>
#include <memory>

#include "haptic/device.h"
#include "haptic/simulation.h"

namespace tissue {

/// A hand with a force sensor that touches a tissue of its own: another device's positions, and the force that the tool has on a model which
/// nobody else sees. To try a law that learns without a robot.
class HiddenTissue final : public Device {
   public:
    /// truth, options: as HapticModel has them; those of a session whose map is the hand's.
    HiddenTissue(std::unique_ptr<Device> hand, const TissueModel& truth, HapticOptions options);

    std::string name() const override { return hand_->name() + " on a hidden tissue"; }
    void start() override { hand_->start(); }
    DeviceSample read(double time_s) noexcept override;
    DeviceSample stand_still(double time_s) noexcept override;
    /// To rest before the next read; any thread's. Where the model that plays is put to rest, and its memory goes, this one must be too.
    void reset() noexcept { reset_.store(true, std::memory_order_relaxed); }
    void write(const Eigen::Vector3d& force_N) noexcept override { hand_->write(force_N); }
    bool finished() const noexcept override { return hand_->finished(); }
    void stop() noexcept override { hand_->stop(); }
    std::vector<std::pair<std::string, double>> statistics() const override { return hand_->statistics(); }

   private:
    std::unique_ptr<Device> hand_;
    HapticModel model_;
    Simulation simulation_;
    std::atomic<bool> reset_{false};
    double last_s_ = 0;  ///< time of the last read, or of standing still
};

}  // namespace tissue
