#pragma once

#include "haptic/device.h"

namespace tissue {

/// A device that runs for as long as this lives. The one place that starts a device, and that makes its force zero and
/// stops it, however the work in between ends: by its end, by an exception, by a start() that throws.
class RunningDevice {
   public:
    /// Throws what start() throws.
    explicit RunningDevice(Device& device) : device_(device) {
        try {
            device_.start();
        } catch (...) {
            rest();
            throw;
        }
    }
    ~RunningDevice() { rest(); }
    RunningDevice(const RunningDevice&) = delete;
    RunningDevice& operator=(const RunningDevice&) = delete;

   private:
    void rest() noexcept {
        device_.write(Eigen::Vector3d::Zero());
        device_.stop();
    }

    Device& device_;
};

}  // namespace tissue
