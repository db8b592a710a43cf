#include "cases/measured_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace tissue {
namespace {

constexpr double unit_factor = 100;
constexpr double same_contact_m = 0.0002, same_displacement = 0.05, other_force = 0.3;
constexpr double drift_errors = 5, least_drift = 0.02;
constexpr std::size_t named = 3, least_rows_of_drift = 12;

void doubt_units(const Study& study, const MeasuredTable& table, std::vector<std::string>& doubts) {
    std::vector<double> ratio;
    for (const MeasuredRow& row : table.rows) ratio.push_back(row.force_N.norm() / (study.modulus_N_m() * row.displacement_m.norm()));
    std::nth_element(ratio.begin(), ratio.begin() + static_cast<std::ptrdiff_t>(ratio.size() / 2), ratio.end());
    const double median = ratio[ratio.size() / 2];
    if (median < unit_factor && median > 1 / unit_factor) return;
    doubts.push_back(fmt::format("forces are {:.2g} times modulus, thickness and displacement multiplied, of tissue some 0.3 to 3: is a unit in the header wrong (N or mN, m or mm)?",
                                 median));
}

void doubt_contradictions(const MeasuredTable& table, std::vector<std::string>& doubts) {
    std::vector<const MeasuredRow*> sorted;
    for (const MeasuredRow& row : table.rows) sorted.push_back(&row);
    const auto x = [](const MeasuredRow* row) { return row->contact_m.x(); };
    std::stable_sort(sorted.begin(), sorted.end(), [&](const auto* a, const auto* b) { return x(a) < x(b); });
    std::size_t found = 0;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        const MeasuredRow& a = *sorted[i];
        const MeasuredRow* worst = nullptr;
        double differs = other_force;
        for (std::size_t k = i + 1; k < sorted.size() && x(sorted[k]) - x(&a) <= same_contact_m; ++k) {
            const MeasuredRow& b = *sorted[k];
            if ((a.contact_m - b.contact_m).norm() > same_contact_m) continue;
            if ((a.displacement_m - b.displacement_m).norm() > same_displacement * std::min(a.displacement_m.norm(), b.displacement_m.norm())) continue;
            const double off = (a.force_N - b.force_N).norm() / std::max(a.force_N.norm(), b.force_N.norm());
            if (off > differs) worst = &b, differs = off;
        }
        if (worst && ++found <= named)
            doubts.push_back(fmt::format("lines {} and {}: forces of the same displacement at the same contact differ by {:.0f} %", std::min(a.line, worst->line),
                                         std::max(a.line, worst->line), 100 * differs));
    }
    if (found > named) doubts.push_back(fmt::format("and so do {} more", found - named));
}

void doubt_drift(const MeasuredTable& table, std::vector<std::string>& doubts) {
    std::map<std::string, std::vector<std::size_t>> pushes;
    for (std::size_t i = 0; i < table.rows.size(); ++i)
        if (!table.rows[i].push.empty()) pushes[table.rows[i].push].push_back(i);
    double n = 0, when_when = 0, when_off = 0, off_off = 0, freed = 0;
    for (const auto& [name, rows] : pushes) {
        if (rows.size() < 2) continue;
        double mean_force = 0, mean_when = 0;
        for (const std::size_t i : rows) mean_force += table.rows[i].force_N.norm(), mean_when += static_cast<double>(i);
        mean_force /= static_cast<double>(rows.size());
        mean_when /= static_cast<double>(rows.size());
        for (const std::size_t i : rows) {
            const double when = static_cast<double>(i) - mean_when, off = table.rows[i].force_N.norm() / mean_force - 1;
            when_when += when * when, when_off += when * off, off_off += off * off, n += 1;
        }
        freed += 1;
    }
    const double degrees = n - freed - 1;
    if (n < least_rows_of_drift || degrees < 1 || when_when == 0) return;
    const double slope = when_off / when_when, left = std::max(0.0, off_off - slope * when_off), error = std::sqrt(left / degrees / when_when);
    const double drift = slope * static_cast<double>(table.rows.size() - 1);
    if (std::abs(drift) < least_drift || std::abs(slope) < drift_errors * error) return;
    doubts.push_back(fmt::format("forces drift: repeats of one push {} by {:.0f} % from the first row to the last; zero the sensor, or let the tissue rest between pushes",
                                 drift > 0 ? "grow" : "fall", 100 * std::abs(drift)));
}

}  // namespace

std::vector<std::string> measured_doubts(const Study& study, const MeasuredTable& table) {
    std::vector<std::string> doubts;
    doubt_units(study, table, doubts);
    doubt_contradictions(table, doubts);
    doubt_drift(table, doubts);
    return doubts;
}

}  // namespace tissue
