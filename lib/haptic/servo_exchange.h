#pragma once

#include <atomic>

#include "haptic/device.h"
#include "haptic/latest.h"

namespace tissue {

/// What the tick and the servo thread of a device exchange: positions one way, forces the other. Neither waits for the
/// other, and nothing is allocated.
///
/// A force that is older than three quarters of force_held_s does not go out: zero goes out in its place. A servo
/// period of up to 2.5 ms thus keeps the promise of force_held_s, and ticks every 5 ms are in time.
///
/// Vendor errors. A sample is valid if a position has come, the newest servo period had no error, and none has come
/// since the last read(). So an error between two reads is not hidden by a success after it. The position of a period
/// with an error is not used.
class ServoExchange {
   public:
    // In the tick's thread.

    /// Before the servo starts: positions, forces and errors of an earlier session no longer count.
    void begin() noexcept;
    /// delay_s: time from a position's measurement to the output of the force that answers it, where the servo is on
    /// time. It is part of the age of every position.
    DeviceSample read(double time_s, double delay_s) noexcept;
    void write(const Eigen::Vector3d& force_N) noexcept;
    /// Sets the force to zero and waits until it has gone out: for two servo periods, at most 20 ms where the servo has
    /// stopped.
    void rest() noexcept;

    // In the servo's thread, in each period: force_N(), then measured() or failed().

    /// The newest force, or zero where it is too old.
    Eigen::Vector3d force_N() noexcept;
    void measured(const Eigen::Vector3d& position_m, bool grasp) noexcept;
    /// error: the vendor's code, not 0.
    void failed(int error) noexcept;

    // In any thread.

    int last_error() const noexcept { return last_error_.load(std::memory_order_relaxed); }  ///< since begin(); 0: none
    /// Time since the newest period without an error, or since begin() [s].
    double silent_s() const noexcept;
    /// servo_ticks, cut_off_ticks (periods that found the newest force too old), vendor_errors (periods with an error)
    /// and vendor_error (code of the last one), since begin().
    std::vector<std::pair<std::string, double>> statistics() const;

   private:
    struct Position {
        Eigen::Vector3d m = Eigen::Vector3d::Zero();
        bool grasp = false;
    };
    struct Force {
        Eigen::Vector3d N = Eigen::Vector3d::Zero();
        long long written_ns = 0;  ///< 0: none has been written
    };

    Latest<Position> position_;
    Latest<Force> force_;
    std::atomic<unsigned long> servo_ticks_{0};
    std::atomic<long> cut_off_{0}, errors_{0};
    std::atomic<int> newest_error_{0}, last_error_{0};
    std::atomic<bool> unread_error_{false};
    std::atomic<long long> good_ns_{0};  ///< time of the newest period without an error
    bool has_position_ = false;
    double seen_at_s_ = 0;               ///< schedule time of the read() that found the newest position
};

}  // namespace tissue
