#pragma once

#include "haptic/device.h"

namespace tissue {

/// Runs a device for the lifetime of this object. No other code starts a device. Its force is set to zero and it is
/// stopped however the work in between ends: normally, by an exception, or by a start() that throws.
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
