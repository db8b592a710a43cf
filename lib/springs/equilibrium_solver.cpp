#include "springs/equilibrium_solver.h"

#include <algorithm>
#include <cmath>

#include "error.h"
#include "springs/contact_errors.h"

namespace tissue {

const char* to_string(SolverStatus status) {
    switch (status) {
        case SolverStatus::converged:
            return "held";
        case SolverStatus::unstable:
            return "unstable";
        case SolverStatus::inverted:
            return "inside_out";
        case SolverStatus::no_equilibrium:
            return "lost";
    }
    return "unknown";
}

EquilibriumSolver::EquilibriumSolver(const TissueEnergy& energy, const ContactKernel& kernel, const SolverOptions& options)
    : energy_(energy), options_(options), spacing_m_(kernel.spacing_m()) {
    const int D = energy.dimension();

    number_.assign(static_cast<std::size_t>(D * energy.node_count()), 0);
    for (int node : energy.dependent())
        for (int d = 0; d < D; ++d) number_[static_cast<std::size_t>(D * node + d)] = -1;
    for (int& n : number_)
        if (n >= 0) n = free_++;

    const std::vector<std::pair<int, int>> coupled = kernel.coupled();
    every_contact_ = !coupled.empty();
    if (every_contact_) lay_out(coupled);
}

/// Sets up the pattern of H, from the node pairs that elements or contacts couple, and its elimination order.
void EquilibriumSolver::lay_out(const std::vector<std::pair<int, int>>& coupled) {
    const TissueEnergy& energy = energy_;
    const int D = energy.dimension();
    std::vector<Eigen::Triplet<double>> pattern;
    const auto couple = [&](int node, int other) {
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) {
                const int i = number_[static_cast<std::size_t>(D * node + a)], j = number_[static_cast<std::size_t>(D * other + b)];
                if (j >= 0 && i >= j) pattern.emplace_back(i, j, 0.0);
            }
    };
    for (const auto& kind : energy.kinds())
        for (int e = 0; e < kind->count(); ++e)
            for (Eigen::Index a = 0; a < kind->nodes().cols(); ++a)
                for (Eigen::Index b = 0; b < kind->nodes().cols(); ++b) couple(kind->nodes()(e, a), kind->nodes()(e, b));
    for (const auto& [i, j] : coupled) {
        couple(i, j);
        couple(j, i);
    }
    H_.resize(free_, free_);
    H_.setFromTriplets(pattern.begin(), pattern.end());
    H_.makeCompressed();
    factor_.analyse(H_);

    slots_.clear();
    for (const auto& kind : energy.kinds()) {
        std::vector<int>& slots = slots_.emplace_back();
        const Eigen::Index n = D * kind->nodes().cols();
        for (int e = 0; e < kind->count(); ++e)
            for (Eigen::Index a = 0; a < n; ++a)
                for (Eigen::Index b = 0; b < n; ++b) {
                    const auto dof = [&](Eigen::Index k) {
                        return number_[static_cast<std::size_t>(kind->nodes()(e, k / D) * D + k % D)];
                    };
                    const bool stored = dof(b) >= 0 && dof(a) >= dof(b);
                    slots.push_back(stored ? static_cast<int>(entry(dof(a), dof(b)) - H_.valuePtr()) : -1);
                }
    }
}

void EquilibriumSolver::make_room() {
    if (every_contact_) return;
    std::vector<std::vector<int>> nodes;
    for (const DisplacedTool& tool : tools_) nodes.push_back(tool.contact.rows.nodes);
    if (room_for_ == nodes) return;
    std::vector<std::pair<int, int>> coupled;
    for (const std::vector<int>& of_tool : nodes)
        for (int i : of_tool)
            for (int j : of_tool)
                if (i <= j) coupled.emplace_back(i, j);
    lay_out(coupled);
    room_for_ = std::move(nodes);
}

double* EquilibriumSolver::entry(int row, int column) {
    const int* begin = H_.innerIndexPtr() + H_.outerIndexPtr()[column];
    const int* end = H_.innerIndexPtr() + H_.outerIndexPtr()[column + 1];
    return H_.valuePtr() + (std::lower_bound(begin, end, row) - H_.innerIndexPtr());
}

/// max |g| over |F|; computes g on the free degrees of freedom. To each tool's force in |F| is added that of a
/// displacement of 1e-4 of the nodes' spacing, because the force is 0 at zero displacement.
double EquilibriumSolver::out_of_balance(const Eigen::VectorXd& constants, const NodeField& u, Eigen::VectorXd& g) const {
    NodeField f = energy_.force(constants, u);
    const Eigen::Index D = u.cols();
    double size_N = 0;
    for (const auto& [contact, push_m] : tools_) {
        const ContactSpring::Load load = contact.load(push_m, contact.gather(u));
        for (std::size_t i = 0; i < contact.rows.nodes.size(); ++i)
            f.row(contact.rows.nodes[i]) += load.node_N.segment(D * static_cast<Eigen::Index>(i), D).transpose();
        size_N += load.tool_force_N.norm() + 1e-4 * spacing_m_ * contact.push_N_m();
    }
    g.resize(free_);
    for (std::size_t i = 0; i < number_.size(); ++i)
        if (number_[i] >= 0) g[number_[i]] = f.data()[i];
    return g.lpNorm<Eigen::Infinity>() / size_N;
}

/// False when H has a pivot of zero.
bool EquilibriumSolver::factorise(const Eigen::VectorXd& constants, const NodeField& u) {
    const int D = energy_.dimension();
    std::fill(H_.valuePtr(), H_.valuePtr() + H_.nonZeros(), 0.0);
    ElementMatrix unit;
    for (std::size_t k = 0; k < slots_.size(); ++k) {
        const Elements& kind = *energy_.kinds()[k];
        const int* slot = slots_[k].data();
        for (int e = 0; e < kind.count(); ++e) {
            kind.tangent(e, u, unit);
            const double constant = constants[energy_.first_of(k) + e];
            for (Eigen::Index a = 0; a < unit.rows(); ++a)
                for (Eigen::Index b = 0; b < unit.cols(); ++b, ++slot)
                    if (*slot >= 0) H_.valuePtr()[*slot] += constant * unit(a, b);
        }
    }
    for (const DisplacedTool& tool : tools_) {
        const ContactSpring& contact = tool.contact;
        const Eigen::MatrixXd block = contact.tangent(tool.push_m, contact.gather(u));
        const auto dof = [&](Eigen::Index k) {
            return number_[static_cast<std::size_t>(contact.rows.nodes[static_cast<std::size_t>(k / D)] * D + k % D)];
        };
        for (Eigen::Index a = 0; a < block.rows(); ++a)
            for (Eigen::Index b = 0; b < block.cols(); ++b)
                if (dof(b) >= 0 && dof(a) >= dof(b)) *entry(dof(a), dof(b)) += block(a, b);
    }
    return factor_.factorise(H_);
}

/// Newton's method at the current tool displacements. Leaves u unchanged if it does not converge.
bool EquilibriumSolver::balance(const Eigen::VectorXd& constants, NodeField& u, int& iterations) {
    NodeField trial = u;
    Eigen::VectorXd g;
    for (int iteration = 0; iteration <= options_.max_newton; ++iteration) {
        const double off = out_of_balance(constants, trial, g);
        if (off <= options_.tolerance) {
            u = trial;
            return true;
        }
        if (!std::isfinite(off) || iteration == options_.max_newton || !factorise(constants, trial)) return false;
        const Eigen::VectorXd step = factor_.solve(g);
        for (std::size_t i = 0; i < number_.size(); ++i)
            if (number_[i] >= 0) trial.data()[i] -= step[number_[i]];
        ++iterations;
    }
    return false;
}

EquilibriumState EquilibriumSolver::indent(const Eigen::VectorXd& constants, std::vector<DisplacedTool> tools, const EquilibriumState* from) {
    const int D = energy_.dimension();
    if (tools.empty()) throw MismatchError("at least one tool is needed");
    if (from && from->others.size() + 1 > tools.size()) throw MismatchError("the start has more tools than the equilibrium");
    for (const DisplacedTool& tool : tools) {
        const std::vector<int>& nodes = tool.contact.rows.nodes;
        if (std::all_of(nodes.begin(), nodes.end(), [&](int node) { return number_[static_cast<std::size_t>(D * node)] < 0; }))
            throw FixedContactError("the contact is on the fixed edge");
    }
    tools_ = std::move(tools);
    const std::size_t count = tools_.size();
    make_room();
    EquilibriumState state;
    state.displacement = from ? from->displacement : NodeField::Zero(energy_.node_count(), D);
    std::vector<Point> start_m(count, Point::Zero(D)), way_m;
    for (std::size_t t = 0; from && t < from->others.size() + 1; ++t) start_m[t] = t == 0 ? from->push_m : from->others[t - 1].push_m;
    double farthest_m = 0;
    for (std::size_t t = 0; t < count; ++t) {
        way_m.emplace_back(tools_[t].push_m - start_m[t]);
        farthest_m = std::max(farthest_m, way_m[t].norm());
    }
    const auto go_to = [&](double part) {
        for (std::size_t t = 0; t < count; ++t) tools_[t].push_m = start_m[t] + part * way_m[t];
    };
    const double longest_m = spacing_m_ * (D == 3 ? options_.solid_load_step : options_.load_step);
    const double steps = std::min(std::max(1.0, std::ceil(farthest_m / longest_m - 1e-9)), 1 / options_.smallest_step);
    double done = 0, step = 1 / steps;
    while (done < 1) {
        const double next = done + step > 1 - 1e-9 ? 1 : done + step;
        go_to(next);
        if (balance(constants, state.displacement, state.newton)) {
            done = next;
        } else if ((step /= 2) < options_.smallest_step) {
            state.status = SolverStatus::no_equilibrium;
            break;
        }
    }
    go_to(done);
    energy_.complete(state.displacement);
    state.energy_J = energy_.energy(constants, state.displacement);
    for (std::size_t t = 0; t < count; ++t) {
        const auto& [contact, push_m] = tools_[t];
        const ContactSpring::Load load = contact.load(push_m, contact.gather(state.displacement));
        state.energy_J += load.energy_J;
        if (t > 0) {
            state.others.push_back({push_m, load.tool_force_N});
            continue;
        }
        state.push_m = push_m;
        state.contact_force_N = load.tool_force_N;
    }
    const bool regular = factorise(constants, state.displacement);
    if (state.status == SolverStatus::converged && !(regular && factor_.is_definite()))
        state.status = SolverStatus::unstable;
    else if (state.status == SolverStatus::converged && !(energy_.smallest_ratio(state.displacement) > 0))
        state.status = SolverStatus::inverted;
    u_ = state.displacement;
    return state;
}

/// The only tool, for derivatives; throws MismatchError if there are several.
const DisplacedTool& EquilibriumSolver::the_tool() const {
    if (tools_.size() != 1) throw MismatchError("derivatives are supported for one tool only");
    return tools_.front();
}

EquilibriumDerivative EquilibriumSolver::derivative(const Eigen::MatrixXd& constants_by, const Eigen::MatrixXd& stiffness_by) const {
    const int D = energy_.dimension();
    const auto& [contact, push_m] = the_tool();
    const Eigen::Index P = constants_by.cols();
    // dg/dp: unit forces of the elements, then those of the contact.
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> g = Eigen::MatrixXd::Zero(free_, P);
    ElementVector unit;
    for (std::size_t k = 0; k < energy_.kinds().size(); ++k) {
        const Elements& kind = *energy_.kinds()[k];
        for (int e = 0; e < kind.count(); ++e) {
            kind.force(e, u_, unit);
            for (Eigen::Index a = 0; a < unit.size(); ++a) {
                const int row = number_[static_cast<std::size_t>(kind.nodes()(e, a / D) * D + a % D)];
                if (row >= 0) g.row(row) += unit[a] * constants_by.row(energy_.first_of(k) + e);
            }
        }
    }
    const std::vector<int>& nodes = contact.rows.nodes;
    const Eigen::VectorXd at = contact.gather(u_);
    EquilibriumDerivative by{Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(number_.size()), P), Eigen::MatrixXd::Zero(D, P)};
    for (int m = 0; m < stiffness_by.rows(); ++m) {
        const ContactSpring::Load load = contact.by_parameter_row(m, push_m, at);
        by.contact_force += load.tool_force_N * stiffness_by.row(m);
        for (Eigen::Index a = 0; a < load.node_N.size(); ++a) {
            const int row = number_[static_cast<std::size_t>(D * nodes[static_cast<std::size_t>(a / D)] + a % D)];
            if (row >= 0) g.row(row) += load.node_N[a] * stiffness_by.row(m);
        }
    }
    const Eigen::MatrixXd du = -factor_.solve(Eigen::MatrixXd(g));
    for (std::size_t i = 0; i < number_.size(); ++i)
        if (number_[i] >= 0) by.displacement.row(static_cast<Eigen::Index>(i)) = du.row(number_[i]);
    for (Eigen::Index p = 0; p < P; ++p) energy_.complete(Eigen::Map<NodeField>(by.displacement.col(p).data(), energy_.node_count(), D));
    const Eigen::MatrixXd hand_by = contact.tool_force_by_nodes(push_m, at);
    for (std::size_t i = 0; i < nodes.size(); ++i)
        by.contact_force += hand_by.middleCols(D * static_cast<Eigen::Index>(i), D) * by.displacement.middleRows(D * nodes[i], D);
    return by;
}

ForceDerivative EquilibriumSolver::force_derivative() const {
    const int D = energy_.dimension();
    const auto& [contact, push_m] = the_tool();
    const std::vector<int>& nodes = contact.rows.nodes;
    const Eigen::VectorXd at = contact.gather(u_);
    const Eigen::MatrixXd hand_by = contact.tool_force_by_nodes(push_m, at);
    Eigen::MatrixXd pulled = Eigen::MatrixXd::Zero(free_, D);
    for (Eigen::Index a = 0; a < hand_by.cols(); ++a) {
        const int row = number_[static_cast<std::size_t>(D * nodes[static_cast<std::size_t>(a / D)] + a % D)];
        if (row >= 0) pulled.row(row) += hand_by.col(a).transpose();
    }
    const Eigen::MatrixXd solved = factor_.solve(pulled);
    NodeField by_force = NodeField::Zero(static_cast<Eigen::Index>(number_.size()), D);  // d hand / d(nodal forces)
    for (std::size_t i = 0; i < number_.size(); ++i)
        if (number_[i] >= 0) by_force.row(static_cast<Eigen::Index>(i)) = -solved.row(number_[i]);

    ForceDerivative by{Eigen::MatrixXd::Zero(D, energy_.constant_count()), Eigen::MatrixXd::Zero(D, contact.parameter_value.size())};
    ElementVector unit;
    for (std::size_t k = 0; k < energy_.kinds().size(); ++k) {
        const Elements& kind = *energy_.kinds()[k];
        for (int e = 0; e < kind.count(); ++e) {
            kind.force(e, u_, unit);
            auto column = by.by_constant.col(energy_.first_of(k) + e);
            for (Eigen::Index a = 0; a < unit.size(); ++a) column += unit[a] * by_force.row(kind.nodes()(e, a / D) * D + a % D).transpose();
        }
    }
    for (Eigen::Index m = 0; m < by.by_parameter_row.cols(); ++m) {
        const ContactSpring::Load load = contact.by_parameter_row(static_cast<int>(m), push_m, at);
        by.by_parameter_row.col(m) = load.tool_force_N;
        for (Eigen::Index a = 0; a < load.node_N.size(); ++a)
            by.by_parameter_row.col(m) += load.node_N[a] * by_force.row(D * nodes[static_cast<std::size_t>(a / D)] + a % D).transpose();
    }
    return by;
}

}  // namespace tissue
