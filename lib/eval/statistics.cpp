#include "eval/statistics.h"

#include <fmt/format.h>
#include <gsl/gsl_statistics_double.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "gsl.h"

namespace tissue {

Statistics statistics_of(std::vector<double> sample, int no_reference) {
    const auto known = std::remove_if(sample.begin(), sample.end(), [](double value) { return std::isnan(value); });
    no_reference += static_cast<int>(sample.end() - known);
    sample.erase(known, sample.end());
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    if (sample.empty()) return {none, none, none, 0, 0, no_reference};
    std::sort(sample.begin(), sample.end());
    const int missing = static_cast<int>(std::count_if(sample.begin(), sample.end(), [](double value) { return std::isinf(value); }));
    const auto quantile = [&](double p) {
        const double value = gsl_stats_quantile_from_sorted_data(sample.data(), 1, sample.size(), p);
        if (!std::isnan(value)) return value;
        // the interpolation made 0 * infinity: the quantile is exactly this value
        return sample[static_cast<std::size_t>(p * static_cast<double>(sample.size() - 1))];
    };
    return {quantile(0.5), quantile(0.95), sample.back(), static_cast<int>(sample.size()) - missing, missing, no_reference};
}

std::string n_of_N(const Statistics& s) { return fmt::format("{} of {}", s.n, s.of()); }

std::string n_of_N(const Statistics& s, const std::string& what) {
    std::string text = n_of_N(s) + " " + what;
    if (s.missing > 0) text += fmt::format(", {} without an answer", s.missing);
    if (s.no_reference > 0) text += fmt::format(", {} without a reference", s.no_reference);
    return text;
}

std::string percent(double value, int digits) { return std::isfinite(value) ? fmt::format("{:.{}f} %", 100 * value, digits) : "none"; }

}  // namespace tissue
