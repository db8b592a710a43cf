#include "haptic/band_cholesky.h"

#include <algorithm>
#include <cmath>

#include "hot_loop.h"

namespace tissue {
namespace kernel {

/// Right-looking factorisation: each finished column j is subtracted from the b columns after it.
/// Returns false at a pivot that is not above `smallest`.
TISSUE_HOT bool factor_band(double* a, int n, int b, double smallest) {
    const std::size_t stride = static_cast<std::size_t>(b) + 1;
    for (int j = 0; j < n; ++j) {
        double* __restrict column = a + static_cast<std::size_t>(j) * stride;
        if (!(column[0] > smallest)) return false;
        const double pivot = std::sqrt(column[0]), inverse = 1 / pivot;
        const int below = std::min(b, n - 1 - j);
        column[0] = inverse;  // stored inverted, so that solving multiplies
        for (int k = 1; k <= below; ++k) column[k] *= inverse;
        for (int k = 1; k <= below; ++k) {
            const double factor = column[k];
            if (factor == 0) continue;
            double* __restrict other = a + (static_cast<std::size_t>(j) + static_cast<std::size_t>(k)) * stride;
            const double* __restrict from = column + k;
            const int count = below - k + 1;
            for (int m = 0; m < count; ++m) other[m] -= factor * from[m];
        }
    }
    return true;
}

TISSUE_HOT void solve_band(const double* a, int n, int b, double* __restrict x) {
    const std::size_t stride = static_cast<std::size_t>(b) + 1;
    for (int j = 0; j < n; ++j) {
        const double* column = a + static_cast<std::size_t>(j) * stride;
        const double value = x[j] *= column[0];
        const int below = std::min(b, n - 1 - j);
        for (int k = 1; k <= below; ++k) x[j + k] -= column[k] * value;
    }
    for (int j = n - 1; j >= 0; --j) {
        const double* column = a + static_cast<std::size_t>(j) * stride;
        const int below = std::min(b, n - 1 - j);
        double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
        int k = 1;
        for (; k + 3 <= below; k += 4) {
            s0 += column[k] * x[j + k];
            s1 += column[k + 1] * x[j + k + 1];
            s2 += column[k + 2] * x[j + k + 2];
            s3 += column[k + 3] * x[j + k + 3];
        }
        for (; k <= below; ++k) s0 += column[k] * x[j + k];
        x[j] = (x[j] - ((s0 + s1) + (s2 + s3))) * column[0];
    }
}

}  // namespace kernel

BandCholesky::BandCholesky(int order, int half_bandwidth)
    : n_(order), b_(half_bandwidth),
      a_(static_cast<std::size_t>(order) * static_cast<std::size_t>(half_bandwidth + 1), 0.0) {}

void BandCholesky::set_zero() noexcept {
    std::fill(a_.begin(), a_.end(), 0.0);
}

bool BandCholesky::factor() noexcept {
    double largest = 0;
    for (int j = 0; j < n_; ++j) largest = std::max(largest, at(j, j));
    return kernel::factor_band(a_.data(), n_, b_, 1e-10 * largest);
}

void BandCholesky::solve(double* x) const noexcept {
    kernel::solve_band(a_.data(), n_, b_, x);
}

FreeNumbering::FreeNumbering(const RealtimeMesh& mesh) {
    per_node = mesh.law().axes_apart() ? 1 : 2;
    const int N = mesh.node_count();
    std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(N));
    for (int slot : mesh.slot_of_spring()) {
        const Eigen::Vector2i ends = mesh.nodes_of_slot(slot);
        neighbours[static_cast<std::size_t>(ends[0])].push_back(ends[1]);
        neighbours[static_cast<std::size_t>(ends[1])].push_back(ends[0]);
        if (!mesh.fixed(ends[0]) || !mesh.fixed(ends[1])) free_slots.push_back(slot);
    }
    std::sort(free_slots.begin(), free_slots.end());

    // The numbering with the narrower band of two: the mesh's own, and that of Cuthill and McKee.
    const auto bandwidth = [&](const std::vector<int>& order_of) {
        int widest = 0;
        for (int slot : free_slots) {
            const Eigen::Vector2i ends = mesh.nodes_of_slot(slot);
            const int i = order_of[static_cast<std::size_t>(ends[0])], j = order_of[static_cast<std::size_t>(ends[1])];
            if (i >= 0 && j >= 0) widest = std::max(widest, std::abs(i - j));
        }
        return widest;
    };
    std::vector<int> natural(static_cast<std::size_t>(N), -1), walked = natural;
    int count = 0;
    for (int node = 0; node < N; ++node)
        if (!mesh.fixed(node)) natural[static_cast<std::size_t>(node)] = count++;

    std::vector<int> by_degree(static_cast<std::size_t>(N));
    for (int node = 0; node < N; ++node) by_degree[static_cast<std::size_t>(node)] = node;
    const auto degree_less = [&](int a, int b) {
        return neighbours[static_cast<std::size_t>(a)].size() < neighbours[static_cast<std::size_t>(b)].size();
    };
    std::stable_sort(by_degree.begin(), by_degree.end(), degree_less);
    std::vector<int> queue;
    for (int start : by_degree) {
        if (mesh.fixed(start) || walked[static_cast<std::size_t>(start)] >= 0) continue;
        walked[static_cast<std::size_t>(start)] = static_cast<int>(queue.size());
        queue.push_back(start);
        for (std::size_t head = queue.size() - 1; head < queue.size(); ++head) {
            std::vector<int> next = neighbours[static_cast<std::size_t>(queue[head])];
            std::stable_sort(next.begin(), next.end(), degree_less);
            for (int node : next)
                if (!mesh.fixed(node) && walked[static_cast<std::size_t>(node)] < 0) {
                    walked[static_cast<std::size_t>(node)] = static_cast<int>(queue.size());
                    queue.push_back(node);
                }
        }
    }
    number = bandwidth(walked) < bandwidth(natural) ? walked : natural;
    order = per_node * count;
    half_bandwidth = per_node * bandwidth(number) + per_node - 1;
}

void add_stiffness(const RealtimeMesh& mesh, const FreeNumbering& numbering, const Eigen::VectorXd& theta,
                   const NodeColumns& u, double scale, bool convex, BandCholesky& A) noexcept {
    for (int slot : numbering.free_slots) {
        const Eigen::Vector2i ends = mesh.nodes_of_slot(slot);
        const int i = numbering.number[static_cast<std::size_t>(ends[0])];
        const int j = numbering.number[static_cast<std::size_t>(ends[1])];
        const double strength = scale * theta[slot];
        if (numbering.per_node == 1) {
            if (i >= 0) A.at(i, i) += strength;
            if (j >= 0) A.at(j, j) += strength;
            if (i >= 0 && j >= 0) A.at(std::max(i, j), std::min(i, j)) -= strength;
            continue;
        }
        const Eigen::Matrix2d k = strength * mesh.unit_stiffness(slot, u, convex);
        for (int n : {i, j})
            if (n >= 0) {
                A.at(2 * n, 2 * n) += k(0, 0);
                A.at(2 * n + 1, 2 * n) += k(1, 0);
                A.at(2 * n + 1, 2 * n + 1) += k(1, 1);
            }
        if (i < 0 || j < 0) continue;
        const int low = std::min(i, j), high = std::max(i, j);
        for (int a : {0, 1})
            for (int b : {0, 1}) A.at(2 * high + a, 2 * low + b) -= k(a, b);
    }
}

}  // namespace tissue
