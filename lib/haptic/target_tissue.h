#pragma once

#include <atomic>
#include <memory>

#include "haptic/device.h"
#include "haptic/simulation.h"

namespace tissue {

/// A device with a simulated force sensor on a synthetic target tissue. The positions are those of another device, and
/// measured_N is the force of its tool on the target tissue. It serves to test adaptation in a session without a robot.
class TargetTissue final : public Device {
   public:
    /// hand: the device that gives the positions. `target`: model of the target tissue. options: those of the session,
    /// with the map of `hand`. Throws as HapticModel.
    TargetTissue(std::unique_ptr<Device> hand, const TissueModel& target, HapticOptions options);

    std::string name() const override { return hand_->name() + " on a target tissue"; }
    void start() override { hand_->start(); }
    DeviceSample read(double time_s) noexcept override;
    DeviceSample skip_tick(double time_s) noexcept override;
    /// Puts the target tissue to rest before the next read(). It must be called when the session's model is put to rest
    /// and the state of its Maxwell branches is lost. May be called from any thread.
    void reset() noexcept { reset_.store(true, std::memory_order_relaxed); }
    void write(const Eigen::Vector3d& force_N) noexcept override { hand_->write(force_N); }
    bool finished() const noexcept override { return hand_->finished(); }
    void stop() noexcept override { hand_->stop(); }
    std::string failure() const override { return hand_->failure(); }
    std::string last_error() const override { return hand_->last_error(); }
    std::vector<std::pair<std::string, double>> statistics() const override { return hand_->statistics(); }

   private:
    std::unique_ptr<Device> hand_;
    HapticModel model_;
    Simulation simulation_;
    std::atomic<bool> reset_{false};
    double last_s_ = 0;  ///< time of the last read() or skip_tick()
};

}  // namespace tissue
