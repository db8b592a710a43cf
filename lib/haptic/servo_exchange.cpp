#include "haptic/servo_exchange.h"

#include "haptic/realtime_thread.h"

namespace tissue {
namespace {

constexpr auto let_go_ns = static_cast<long long>(0.75e9 * force_held_s);

}  // namespace

void ServoExchange::begin() noexcept {
    force_.back() = {};
    force_.publish();
    position_.fetch();
    has_position_ = false;
    servo_ticks_ = 0;
    cut_off_ = errors_ = 0;
    newest_error_ = last_error_ = 0;
    unread_error_ = false;
    good_ns_ = now_ns();
}

DeviceSample ServoExchange::read(double time_s, double delay_s) noexcept {
    // first, so that an error that comes now is in the next sample at the latest
    const bool failed = unread_error_.exchange(false, std::memory_order_acquire);
    if (position_.fetch()) {
        has_position_ = true;
        seen_at_s_ = time_s;
    }
    DeviceSample sample;
    sample.position_m = position_.front().m;
    sample.grasp = has_position_ && position_.front().grasp;
    sample.valid = has_position_ && !failed && newest_error_.load(std::memory_order_relaxed) == 0;
    sample.age_s = has_position_ ? time_s - seen_at_s_ + delay_s : delay_s;
    return sample;
}

void ServoExchange::write(const Eigen::Vector3d& force_N) noexcept {
    force_.back() = {force_N, now_ns()};
    force_.publish();
}

void ServoExchange::rest() noexcept {
    write(Eigen::Vector3d::Zero());
    const unsigned long until = servo_ticks_.load() + 2;
    for (int k = 0; k < 20 && servo_ticks_.load() < until; ++k) sleep_until(now_ns() + 1'000'000);
}

Eigen::Vector3d ServoExchange::force_N() noexcept {
    force_.fetch();
    const Force& newest = force_.front();
    if (now_ns() - newest.written_ns <= let_go_ns) return newest.N;
    cut_off_.fetch_add(1, std::memory_order_relaxed);
    return Eigen::Vector3d::Zero();
}

void ServoExchange::measured(const Eigen::Vector3d& position_m, bool grasp) noexcept {
    position_.back() = {position_m, grasp};
    position_.publish();
    newest_error_.store(0, std::memory_order_relaxed);
    good_ns_.store(now_ns(), std::memory_order_relaxed);
    servo_ticks_.fetch_add(1, std::memory_order_release);
}

void ServoExchange::failed(int error) noexcept {
    newest_error_.store(error, std::memory_order_relaxed);
    last_error_.store(error, std::memory_order_relaxed);
    errors_.fetch_add(1, std::memory_order_relaxed);
    unread_error_.store(true, std::memory_order_release);
    servo_ticks_.fetch_add(1, std::memory_order_release);
}

double ServoExchange::silent_s() const noexcept {
    return 1e-9 * static_cast<double>(now_ns() - good_ns_.load(std::memory_order_relaxed));
}

std::vector<std::pair<std::string, double>> ServoExchange::statistics() const {
    return {{"servo_ticks", static_cast<double>(servo_ticks_.load())},
            {"cut_off_ticks", static_cast<double>(cut_off_.load())},
            {"vendor_errors", static_cast<double>(errors_.load())},
            {"vendor_error", static_cast<double>(last_error_.load())}};
}

}  // namespace tissue
