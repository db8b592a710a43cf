#include "cases/measurement_warnings.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace tissue {
namespace {

constexpr double unit_factor = 100;
constexpr double same_contact_m = 0.0002, same_displacement = 0.05, other_force = 0.3;
constexpr double drift_errors = 5, least_drift = 0.02;
constexpr std::size_t named = 3, least_rows_of_drift = 12;

/// ratio: for each row, force / (modulus, thickness and displacement multiplied); at least one row.
void doubt_units(std::vector<double> ratio, std::vector<std::string>& doubts) {
    std::nth_element(ratio.begin(), ratio.begin() + static_cast<std::ptrdiff_t>(ratio.size() / 2), ratio.end());
    const double median = ratio[ratio.size() / 2];
    if (median < unit_factor && median > 1 / unit_factor) return;
    doubts.push_back(fmt::format("forces are {:.2g} times the product of modulus, thickness and displacement, which for tissue is 0.3 to 3: is a unit in the header wrong (N or mN, m or mm)?",
                                 median));
}

/// Finds pairs of rows with the same contact and displacement in a tree of bounding boxes. It skips a box whose rows
/// are elsewhere, or whose forces cannot differ enough. A loop over all pairs would take half a minute for 60,000 rows
/// at one contact.
class RowTree {
   public:
    explicit RowTree(const std::vector<const MeasuredRow*>& rows) : rows_(rows), order_(rows.size()) {
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        if (!rows_.empty()) build(0, rows_.size());
    }

    struct Found {
        std::size_t row;  ///< rows.size() where there is none
        double differs;   ///< difference of the forces over the larger one
    };
    /// Searches the rows after `row` that have its contact and displacement. Finds the one whose force differs most,
    /// and by more than `differs`; the first of equal ones. any: stops at the first box with a row that differs by
    /// more.
    Found after(std::size_t row, double differs, bool any) const {
        Found found{rows_.size(), differs};
        if (!rows_.empty()) search(0, row, any, found);
        return found;
    }

   private:
    using Box = Eigen::AlignedBox2d;
    struct Node {
        Box contact_m, displacement_m, force_N;
        std::size_t begin, end, last;  ///< its rows in order_; the largest number of its rows
        std::size_t right;  ///< node of its second half; that of the first half is the next node. 0: a leaf
    };
    static constexpr std::size_t leaf_rows = 8;

    std::size_t build(std::size_t begin, std::size_t end) {
        const std::size_t at = nodes_.size();
        nodes_.push_back({{}, {}, {}, begin, end, 0, 0});
        Node node = nodes_[at];
        for (std::size_t k = begin; k < end; ++k) {
            const MeasuredRow& row = *rows_[order_[k]];
            node.contact_m.extend(row.contact_m);
            node.displacement_m.extend(row.displacement_m);
            node.force_N.extend(row.force_N);
            node.last = std::max(node.last, order_[k]);
        }
        nodes_[at] = node;
        if (end - begin <= leaf_rows) return at;
        // divides along the widest coordinate, measured in the tolerances of equal rows
        const auto size = [](const Box& box) { return box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm(); };
        const Eigen::Vector2d wide[] = {node.contact_m.sizes() / same_contact_m, node.displacement_m.sizes() / (same_displacement * size(node.displacement_m)),
                                        node.force_N.sizes() / (other_force * size(node.force_N))};
        int what = 0, axis = 0;
        for (int w = 0; w < 3; ++w)
            for (int a = 0; a < 2; ++a)
                if (wide[w][a] > wide[what][axis]) what = w, axis = a;
        const auto value = [&](std::size_t row) {
            const MeasuredRow& r = *rows_[row];
            return (what == 0 ? r.contact_m : what == 1 ? r.displacement_m : r.force_N)[axis];
        };
        const std::size_t middle = begin + (end - begin) / 2;
        const auto place = [&](std::size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
        std::nth_element(place(begin), place(middle), place(end), [&](std::size_t a, std::size_t b) { return value(a) < value(b); });
        build(begin, middle);
        const std::size_t right = build(middle, end);
        nodes_[at].right = right;
        return at;
    }

    /// Upper bound of the relative force difference between a row and any row in the box.
    static double most(const MeasuredRow& row, const Box& force_N) {
        const double apart = (row.force_N - force_N.min()).cwiseAbs().cwiseMax((row.force_N - force_N.max()).cwiseAbs()).norm();
        return apart / std::max(row.force_N.norm(), force_N.exteriorDistance(Eigen::Vector2d(0, 0)));
    }

    void search(std::size_t at, std::size_t row, bool any, Found& found) const {
        constexpr double rounding = 1 + 1e-9;  // so that rounding does not skip a box with a matching row
        const Node& node = nodes_[at];
        const MeasuredRow& a = *rows_[row];
        if (node.last <= row || node.contact_m.exteriorDistance(a.contact_m) > rounding * same_contact_m ||
            node.displacement_m.exteriorDistance(a.displacement_m) > rounding * same_displacement * a.displacement_m.norm() ||
            rounding * most(a, node.force_N) < found.differs)
            return;
        if (node.right) {
            search(at + 1, row, any, found);
            if (!any || found.row == rows_.size()) search(node.right, row, any, found);
            return;
        }
        for (std::size_t k = node.begin; k < node.end; ++k) {
            const std::size_t other = order_[k];
            const MeasuredRow& b = *rows_[other];
            if (other <= row || (a.contact_m - b.contact_m).norm() > same_contact_m) continue;
            if ((a.displacement_m - b.displacement_m).norm() > same_displacement * std::min(a.displacement_m.norm(), b.displacement_m.norm())) continue;
            const double off = (a.force_N - b.force_N).norm() / std::max(a.force_N.norm(), b.force_N.norm());
            if (off > found.differs || (off == found.differs && other < found.row && found.row < rows_.size())) found = {other, off};
        }
    }

    const std::vector<const MeasuredRow*>& rows_;
    std::vector<std::size_t> order_;
    std::vector<Node> nodes_;
};

void doubt_contradictions(const MeasuredTable& table, std::vector<std::string>& doubts) {
    std::vector<const MeasuredRow*> sorted;
    for (const MeasuredRow& row : table.rows) sorted.push_back(&row);
    std::stable_sort(sorted.begin(), sorted.end(), [](const auto* a, const auto* b) { return a->contact_m.x() < b->contact_m.x(); });
    const RowTree tree(sorted);
    std::size_t found = 0;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        const RowTree::Found worst = tree.after(i, other_force, found >= named);
        if (worst.row == sorted.size() || ++found > named) continue;
        const int lines[] = {sorted[i]->line, sorted[worst.row]->line};
        doubts.push_back(fmt::format("lines {} and {}: forces of the same displacement at the same contact differ by {:.0f} %", std::min(lines[0], lines[1]),
                                     std::max(lines[0], lines[1]), 100 * worst.differs));
    }
    if (found > named) doubts.push_back(fmt::format("{} more pairs of lines differ likewise", found - named));
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
    doubts.push_back(fmt::format("forces drift: repeats of one measurement {} by {:.0f} % from the first row to the last; zero the sensor, or let the tissue rest between measurements",
                                 drift > 0 ? "rise" : "fall", 100 * std::abs(drift)));
}

}  // namespace

std::vector<std::string> measurement_warnings(const Study& study, const MeasuredTable& table) {
    std::vector<std::string> doubts;
    std::vector<double> ratio;
    for (const MeasuredRow& row : table.rows) ratio.push_back(row.force_N.norm() / (study.modulus_N_m() * row.displacement_m.norm()));
    doubt_units(std::move(ratio), doubts);
    doubt_contradictions(table, doubts);
    doubt_drift(table, doubts);
    return doubts;
}

std::vector<std::string> measurement_warnings(const Study& study, const std::vector<History>& histories) {
    std::vector<std::string> doubts;
    std::vector<double> ratio;
    for (const History& h : histories)
        for (Eigen::Index t = 0; t < h.time_s.size(); ++t)
            if (const double push_m = h.push_m.row(t).norm(); push_m > 0) ratio.push_back(h.force_N.row(t).norm() / (study.modulus_N_m() * push_m));
    if (!ratio.empty()) doubt_units(std::move(ratio), doubts);
    return doubts;
}

}  // namespace tissue
