#include "haptic/realtime_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "error.h"
#include "hot_loop.h"
#include "springs/law_kernel.h"
#include "springs/region_area.h"

namespace tissue {
namespace {

constexpr int chunk = 256;  ///< squares at a time: their forces stay in the first-level cache

const LawModel& law_of(const TissueModel& model) {
    if (!model.energy_law) throw MismatchError("the model's stiffness is no law");
    return *model.energy_law;
}

}  // namespace

namespace kernel {

/// With P, Q the diagonals at rest and p, q what has been added to them, a square has grown by half of
///   P x q + p x Q + p x q,
/// in which nothing cancels, and its area's derivative is half of the other diagonal, turned: g by the first diagonal's
/// ends, h by the second's.
TISSUE_HOT void squares(int n, const double* __restrict px, const double* __restrict py, const double* __restrict qx,
                        const double* __restrict qy, const double* __restrict gain, const double* __restrict ax,
                        const double* __restrict ay, const double* __restrict bx, const double* __restrict by,
                        const double* __restrict cx, const double* __restrict cy, const double* __restrict dx,
                        const double* __restrict dy, double* __restrict gx, double* __restrict gy, double* __restrict hx,
                        double* __restrict hy) {
    for (int k = 0; k < n; ++k) {
        const double ux = cx[k] - ax[k], uy = cy[k] - ay[k], vx = dx[k] - bx[k], vy = dy[k] - by[k];
        const double x = qx[k] + vx, y = qy[k] + vy;
        const double pull = gain[k] * ((px[k] * vy - py[k] * vx) + (ux * y - uy * x));
        gx[k] = pull * y;
        gy[k] = -pull * x;
        hx[k] = -pull * (py[k] + uy);
        hy[k] = pull * (px[k] + ux);
    }
}

}  // namespace kernel

RealtimeLaw::RealtimeLaw(const TissueModel& model, const RealtimeMesh& springs) : springs_(springs), kernel_(make_contact_kernel(model.mesh, law_of(model).disc_radius_m, law_of(model).ground)) {
    const LawModel& law = law_of(model);
    if (springs.law().name() != "geometric")
        throw MismatchError(fmt::format("a law's springs are geometric, not {}", springs.law().name()));
    const TissueEnergy energy(model.mesh, law.incompressible);
    if (law.constants.size() != energy.constant_count()) throw MismatchError("the law's constants are not those of the mesh");
    patch_ = law.patch;

    for (std::size_t k = 0; k < energy.kinds().size(); ++k) {
        const Elements& kind = *energy.kinds()[k];
        const Eigen::VectorXd constants = law.constants.segment(energy.first_of(k), kind.count());
        if (kind.kind() == "spring") {
            theta_ = springs.to_slots(constants);
        } else if (kind.kind() == "region") {
            std::vector<std::array<int, 2>> edges;
            for (const auto& [i, j] : static_cast<const RegionArea&>(kind).edges()) edges.push_back({kind.nodes()(0, i), kind.nodes()(0, j)});
            add_region(edges, constants[0]);
        } else if (!add_squares(kind, constants)) {
            for (int e = 0; e < kind.count(); ++e) {
                std::vector<std::array<int, 2>> edges;
                for (Eigen::Index c = 0, n = kind.nodes().cols(); c < n; ++c) edges.push_back({kind.nodes()(e, c), kind.nodes()(e, (c + 1) % n)});
                add_region(edges, constants[e]);
            }
        }
    }
}

/// False when the cells are no squares that lie from node to node as a lattice's do.
bool RealtimeLaw::add_squares(const Elements& cells, const Eigen::VectorXd& constants) {
    const Cells& nodes = cells.nodes();
    if (nodes.rows() == 0 || nodes.cols() != 4) return false;
    const int first = nodes.col(0).minCoeff(), count = nodes.col(0).maxCoeff() - first + 1;
    std::vector<bool> taken(static_cast<std::size_t>(count), false);
    for (int e = 0; e < cells.count(); ++e) {
        for (int corner = 1; corner < 4; ++corner)
            if (nodes(e, corner) - nodes(e, 0) != nodes(0, corner) - nodes(0, 0)) return false;
        const auto k = static_cast<std::size_t>(nodes(e, 0) - first);
        if (taken[k]) return false;
        taken[k] = true;
    }
    const auto n = static_cast<std::size_t>(count);
    squares_ = {first, count, nodes(0, 1) - nodes(0, 0), nodes(0, 2) - nodes(0, 0), nodes(0, 3) - nodes(0, 0), {}, {}, {}, {}, {}};
    for (std::vector<double>* list : {&squares_.px, &squares_.py, &squares_.qx, &squares_.qy, &squares_.gain}) list->assign(n, 0);
    for (int e = 0; e < cells.count(); ++e) {
        const auto k = static_cast<std::size_t>(nodes(e, 0) - first);
        const Eigen::RowVector2d p = springs_.rest().row(nodes(e, 2)) - springs_.rest().row(nodes(e, 0)),
                                 q = springs_.rest().row(nodes(e, 3)) - springs_.rest().row(nodes(e, 1));
        squares_.px[k] = p.x();
        squares_.py[k] = p.y();
        squares_.qx[k] = q.x();
        squares_.qy[k] = q.y();
        squares_.gain[k] = constants[e] / (2 * (p.x() * q.y() - p.y() * q.x()));
    }
    return true;
}

void RealtimeLaw::add_region(const std::vector<std::array<int, 2>>& edges, double constant) {
    std::multimap<int, int> next;
    for (const auto& [i, j] : edges) next.emplace(i, j);
    const NodeColumns& rest = springs_.rest();
    const auto begin = static_cast<int>(walk_.size());
    double twice_area = 0;
    while (!next.empty()) {
        std::vector<int> walk = {next.begin()->first};
        for (auto edge = next.begin(); edge != next.end(); edge = next.find(walk.back())) {
            walk.push_back(edge->second);
            next.erase(edge);
        }
        const std::size_t n = walk.size() - 1;  // it ends where it began
        for (std::size_t k = 0; k < n; ++k) {
            const int before = walk[(k + n - 1) % n], at = walk[k], after = walk[k + 1];
            const Eigen::RowVector2d span = rest.row(after) - rest.row(before), from = rest.row(at) - rest.row(walk[0]);
            walk_.push_back({at, before, after, span.x(), span.y()});
            twice_area += (from.x() * span.y() - from.y() * span.x()) / 2;
        }
    }
    regions_.push_back({begin, static_cast<int>(walk_.size()), constant / (2 * twice_area)});
}

void RealtimeLaw::force(const NodeColumns& u, NodeColumns& f) const noexcept {
    springs_.force(theta_, u, f);
    squares_force(u, f);
    for (const Region& region : regions_) {
        const double pull = region.gain * twice_growth(region, u);
        for (int k = region.begin; k < region.end; ++k) {
            const Step& step = walk_[static_cast<std::size_t>(k)];
            f(step.node, 0) += pull * (step.y + u(step.after, 1) - u(step.before, 1));
            f(step.node, 1) -= pull * (step.x + u(step.after, 0) - u(step.before, 0));
        }
    }
}

/// Twice the area that a region has gained [m2]: edge by edge, as it changes with u, so that nothing cancels.
double RealtimeLaw::twice_growth(const Region& region, const NodeColumns& u) const noexcept {
    double twice = 0;
    for (int k = region.begin; k < region.end; ++k) {
        const Step& step = walk_[static_cast<std::size_t>(k)];
        twice += u(step.node, 0) * (step.y + u(step.after, 1)) - u(step.node, 1) * (step.x + u(step.after, 0));
    }
    return twice;
}

void RealtimeLaw::squares_force(const NodeColumns& u, NodeColumns& f) const noexcept {
    alignas(64) double gx[chunk], gy[chunk], hx[chunk], hy[chunk];
    const Eigen::Index N = u.rows();
    for (int done = 0; done < squares_.count; done += chunk) {
        const int n = std::min(chunk, squares_.count - done), a = squares_.first + done;
        const double *ux = u.data() + a, *uy = ux + N;
        double *fx = f.data() + a, *fy = fx + N;
        const auto [b, c, d] = std::array{squares_.b, squares_.c, squares_.d};
        kernel::squares(n, squares_.px.data() + done, squares_.py.data() + done, squares_.qx.data() + done, squares_.qy.data() + done,
                        squares_.gain.data() + done, ux, uy, ux + b, uy + b, ux + c, uy + c, ux + d, uy + d, gx, gy, hx, hy);
        kernel::add_pair(n, gx, fx, fx + c);
        kernel::add_pair(n, gy, fy, fy + c);
        kernel::add_pair(n, hx, fx + b, fx + d);
        kernel::add_pair(n, hy, fy + b, fy + d);
    }
}

double RealtimeLaw::energy(const NodeColumns& u) const noexcept {
    double energy = springs_.potential_energy(theta_, u);
    for (int k = 0; k < squares_.count; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const int a = squares_.first + k;
        if (squares_.gain[i] == 0) continue;
        const Eigen::RowVector2d p = u.row(a + squares_.c) - u.row(a), q = u.row(a + squares_.d) - u.row(a + squares_.b);
        const double twice = squares_.px[i] * q.y() - squares_.py[i] * q.x() + p.x() * (squares_.qy[i] + q.y()) - p.y() * (squares_.qx[i] + q.x());
        energy += squares_.gain[i] * twice * twice / 2;
    }
    for (const Region& region : regions_) {
        const double twice = twice_growth(region, u);
        energy += region.gain * twice * twice / 2;
    }
    return energy;
}

}  // namespace tissue
