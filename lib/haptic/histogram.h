#pragma once

#include <array>
#include <cmath>

namespace tissue {

/// Histogram of positive durations on a logarithmic scale, with bins 1 % wide from 1 ns to about 20 minutes. add() does
/// not allocate. A percentile is the upper edge of its bin; the maximum is exact.
class Histogram {
   public:
    /// us: duration [us].
    void add(double us) noexcept {
        ++count_;
        if (us > max_) max_ = us;
        const double bin = us > low ? std::log2(us / low) * per_octave : 0;
        const auto last = static_cast<double>(bins_.size() - 1);
        ++bins_[static_cast<std::size_t>(bin < last ? bin : last)];
    }

    /// Smallest edge with at least the part `share` (0 to 1) of all values below it [us]; 0 without values.
    double percentile(double share) const noexcept {
        const double wanted = share * static_cast<double>(count_);
        double below = 0;
        for (std::size_t b = 0; b < bins_.size() && count_ > 0; ++b) {
            below += static_cast<double>(bins_[b]);
            if (below >= wanted) return std::fmin(max_, low * std::exp2(static_cast<double>(b + 1) / per_octave));
        }
        return max_;
    }

    double max() const noexcept { return max_; }
    long long count() const noexcept { return count_; }

   private:
    static constexpr double low = 1e-3, per_octave = 70;
    std::array<long long, 70 * 40> bins_{};
    long long count_ = 0;
    double max_ = 0;
};

}  // namespace tissue
