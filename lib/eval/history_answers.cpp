#include "eval/history_answers.h"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "error.h"
#include "mesh/facet.h"
#include "parallel.h"

namespace tissue {
namespace {

/// Weights of the trapezoidal rule [s] (T).
Eigen::VectorXd over_time(const Eigen::VectorXd& time_s) {
    const Eigen::Index T = time_s.size();
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(T);
    for (Eigen::Index n = 1; n < T; ++n) {
        weight[n - 1] += (time_s[n] - time_s[n - 1]) / 2;
        weight[n] += (time_s[n] - time_s[n - 1]) / 2;
    }
    return weight;
}

double square_over_time(const Eigen::VectorXd& time_s, const NodeField& f) { return over_time(time_s).dot(f.rowwise().squaredNorm()); }

/// Row of a field (T x D) at time t, interpolated linearly.
Point row_at(const Eigen::VectorXd& time_s, const NodeField& field, double t) {
    const double* begin = time_s.data();
    const auto n = std::clamp<Eigen::Index>(std::upper_bound(begin, begin + time_s.size(), t) - begin, 1, time_s.size() - 1);
    const double w = std::clamp((t - time_s[n - 1]) / (time_s[n] - time_s[n - 1]), 0.0, 1.0);
    return ((1 - w) * field.row(n - 1) + w * field.row(n)).transpose();
}

/// dF/dt (T x D) by differences of the neighbouring rows.
NodeField rate(const Eigen::VectorXd& time_s, const NodeField& f) {
    NodeField out = NodeField::Zero(f.rows(), f.cols());
    const Eigen::Index T = f.rows();
    for (Eigen::Index n = 0; n < T; ++n) {
        const Eigen::Index a = std::max<Eigen::Index>(n - 1, 0), b = std::min(n + 1, T - 1);
        if (b > a) out.row(n) = (f.row(b) - f.row(a)) / (time_s[b] - time_s[a]);
    }
    return out;
}

/// Place of the tool on the mesh: facet, and weights of its nodes.
struct Touch {
    int facet;
    Eigen::Vector3d weight;
};
Touch touch_at(const SpringMesh& mesh, const Point& contact_m) {
    Touch best{-1, Eigen::Vector3d::Zero()};
    double nearest = std::numeric_limits<double>::infinity();
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        const FacetPoint at = nearest_on_facet(mesh.nodes, mesh.facets, f, contact_m);
        if (at.distance_m < nearest) {
            nearest = at.distance_m;
            best = {static_cast<int>(f), at.weight};
        }
    }
    return best;
}

/// Normal equations of a linear least-squares fit of columns to the reference force; equal weights of histories.
struct Fit {
    explicit Fit(Eigen::Index columns) : A(Eigen::MatrixXd::Zero(columns, columns)), b(Eigen::VectorXd::Zero(columns)) {}
    void add(const Eigen::VectorXd& time_s, const NodeField& truth, const std::vector<NodeField>& columns) {
        const Eigen::VectorXd w = over_time(time_s) / square_over_time(time_s, truth);
        for (Eigen::Index i = 0; i < b.size(); ++i) {
            const NodeField weighted = w.asDiagonal() * columns[static_cast<std::size_t>(i)];
            b[i] += weighted.cwiseProduct(truth).sum();
            for (Eigen::Index j = 0; j < b.size(); ++j) A(i, j) += weighted.cwiseProduct(columns[static_cast<std::size_t>(j)]).sum();
        }
        square += 1;
    }
    Eigen::VectorXd best() const { return A.ldlt().solve(b); }
    double left() const { return square - b.dot(best()); }

    Eigen::MatrixXd A;
    Eigen::VectorXd b;
    double square = 0;
};

constexpr double slow = 0.05;  ///< rms error of `prony` below which inertia does not matter in a history

TissueModel with_energy_model(TissueModel model, EnergyModel energy_model) {
    model.energy_model = std::move(energy_model);
    return model;
}

}  // namespace

HistoryError history_error(const Eigen::VectorXd& time_s, const NodeField& truth_N, const NodeField& answer_N) {
    constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
    if (!(square_over_time(time_s, truth_N) > 0)) return {nothing, nothing};
    if (!answer_N.allFinite()) return {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    const NodeField off = answer_N - truth_N;
    return {std::sqrt(square_over_time(time_s, off) / square_over_time(time_s, truth_N)),
            std::sqrt(off.rowwise().squaredNorm().maxCoeff() / truth_N.rowwise().squaredNorm().maxCoeff())};
}

NodeField play_history(const HapticModel& model, const History& history) {
    const HapticMesh& mesh = *model.meshes.front();
    if (!mesh.energy_model) throw MismatchError("displacement histories need an energy model; this model has spring sets");
    const double dt = model.options.dt_s, step_s = dt / mesh.substeps;
    const auto dynamics = make_dynamics(mesh.dynamics, mesh.springs, {step_s, mesh.damping_1_s, mesh.energy_model.get()});
    MeshState state(mesh.springs, mesh.theta_of_set.col(0));
    state.memory = mesh.energy_model->memory(step_s);
    ToolMemory memory = mesh.energy_model->tool_memory(step_s);
    const Touch places[2] = {touch_at(model.rest, history.contact_m), touch_at(model.rest, history.second_contact_m.value_or(history.contact_m))};
    ToolSpring tool;
    ContactLoad load;
    load.memory = memory.empty() ? nullptr : &memory;

    const Eigen::Index T = history.time_s.size();
    NodeField answer = NodeField::Zero(T, model.dimension());
    Point last = Point::Zero(model.dimension());
    int touching = history.contact[0], before = touching;
    if (touching > 0) mesh.energy_model->contacts().at(places[touching - 1].facet, places[touching - 1].weight, {}, tool);
    Eigen::Index next = 1;
    for (long long tick = 1; next < T; ++tick) {
        const double t = static_cast<double>(tick) * dt;
        // Within an FE step in which the contact changes the tool is away: a new contact begins at the end of the step,
        // an old one ends at its start.
        const auto after = static_cast<std::size_t>(std::min<Eigen::Index>(std::upper_bound(history.time_s.data(), history.time_s.data() + T, t + 1e-9) - history.time_s.data(), T - 1));
        if (const int now = history.contact[after - 1] == history.contact[after] ? history.contact[after] : t + 1e-9 >= history.time_s[T - 1] ? history.contact[after] : 0; now != touching) {
            touching = now;
            memory.forget();
            if (now > 0) mesh.energy_model->contacts().at(places[now - 1].facet, places[now - 1].weight, {}, tool);
        }
        load.tool = touching > 0 ? &tool : nullptr;
        load.push_m = row_at(history.time_s, history.push_m, t);
        ContactLoad now = touching > 0 ? load : ContactLoad{};
        const Point force = dynamics->advance(state, now, step_s, mesh.substeps, mesh.substeps);
        for (; next < T && history.time_s[next] <= t + 1e-12; ++next) {
            const double w = std::clamp((history.time_s[next] - (t - dt)) / dt, 0.0, 1.0);
            if (touching == before)
                answer.row(next) = ((1 - w) * last + w * force).transpose();
            else  // no interpolation of forces across a change of contact
                answer.row(next) = (history.contact[static_cast<std::size_t>(next)] == before ? last : force).transpose();
        }
        last = force;
        before = touching;
        if (!force.allFinite()) {
            answer.bottomRows(T - std::min(next, T - 1)).setConstant(std::numeric_limits<double>::quiet_NaN());
            break;
        }
    }
    return answer;
}

std::vector<std::string> HistoryTable::groups() const {
    std::vector<std::string> names;
    const auto add = [&](const std::string& group) {
        if (std::find(names.begin(), names.end(), group) == names.end()) names.push_back(group);
    };
    for (const HistoryAnswer& a : answers) add(a.group);
    for (const std::string& group : lost_group) add(group);
    return names;
}

namespace {

template <class Value>
Statistics over_group(const HistoryTable& table, const std::string& group, const Value& value) {
    std::vector<double> sample;
    for (const HistoryAnswer& a : table.answers)
        if (group.empty() || a.group == group) sample.push_back(value(a));
    const auto lost = group.empty() ? table.lost_group.size() : std::count(table.lost_group.begin(), table.lost_group.end(), group);
    return statistics_of(sample, static_cast<int>(lost));
}

}  // namespace

Statistics HistoryTable::rms(std::size_t model, const std::string& group) const {
    return over_group(*this, group, [&](const HistoryAnswer& a) { return a.error[model].rms; });
}

Statistics HistoryTable::peak(std::size_t model, const std::string& group) const {
    return over_group(*this, group, [&](const HistoryAnswer& a) { return a.error[model].peak; });
}

Statistics HistoryTable::elastic_rms(const std::string& group) const {
    return over_group(*this, group, [](const HistoryAnswer& a) { return a.elastic.rms; });
}

HistoryTable evaluate_histories(const TissueModel& model, const std::vector<History>& all, const std::string& role, int threads) {
    HistoryTable table;
    std::vector<const History*> histories;
    for (const History& h : all) {
        if (h.role != role) continue;
        if (h.lost.empty()) {
            histories.push_back(&h);
            continue;
        }
        table.lost.push_back(h.name + ": " + h.lost);
        table.lost_group.push_back(h.group);
    }
    if (histories.empty()) return table;
    if (!model.energy_model) throw MismatchError("displacement histories need an energy model; this model has spring sets");
    table.models = {"learned", "long_term", "instantaneous", "best_factor", "kelvin_voigt", "one_branch", "prony"};
    const EnergyModel& energy_model = *model.energy_model;
    HapticOptions options;
    options.heuristic_mesh = false;
    const HapticModel learned(model, options);
    options.damping_ratio = learned.options.damping_ratio;
    const HapticModel at_once(with_energy_model(model, instantaneous(energy_model)), options), after_long(with_energy_model(model, long_term(energy_model)), options);

    const std::size_t H = histories.size();
    std::vector<std::vector<NodeField>> answer(H, std::vector<NodeField>(3));
    const HapticModel* players[3] = {&learned, &after_long, &at_once};
    parallel_for(static_cast<int>(3 * H), threads, [&](int i) {
        const auto h = static_cast<std::size_t>(i) / 3, m = static_cast<std::size_t>(i) % 3;
        answer[h][m] = play_history(*players[m], *histories[h]);
    });

    // fit best_factor, kelvin_voigt and one_branch to these histories
    Fit factor(1), voigt(2);
    std::vector<NodeField> prony(H);  // 0 rows where FE has no run without relaxation
    std::vector<bool> fits(H);
    for (std::size_t h = 0; h < H; ++h) {
        const History& history = *histories[h];
        if (history.elastic_N.rows() == history.time_s.size())
            prony[h] = relaxed(history.time_s, history.elastic_N, energy_model.relaxation.tau_s, energy_model.relaxation.contact_share);
        fits[h] = answer[h][2].allFinite() && prony[h].rows() > 0 && history_error(history.time_s, history.force_N, prony[h]).rms < slow;
    }
    table.fitted_to_all = std::find(fits.begin(), fits.end(), true) == fits.end();
    if (table.fitted_to_all)
        for (std::size_t h = 0; h < H; ++h) fits[h] = answer[h][2].allFinite() && square_over_time(histories[h]->time_s, histories[h]->force_N) > 0;
    for (std::size_t h = 0; h < H; ++h) {
        const NodeField& now = answer[h][2];
        if (!fits[h]) continue;
        factor.add(histories[h]->time_s, histories[h]->force_N, {now});
        voigt.add(histories[h]->time_s, histories[h]->force_N, {now, rate(histories[h]->time_s, now)});
    }
    table.factor = factor.best()[0];
    const Eigen::Vector2d ab = voigt.best();
    table.kelvin_voigt[0] = ab[0];
    table.kelvin_voigt[1] = ab[1];
    double least = std::numeric_limits<double>::infinity();
    Eigen::Vector2d branch = Eigen::Vector2d::Zero();  // coefficients of F and of the relaxing part
    for (double tau_s = 0.01; tau_s < 40; tau_s *= std::pow(10, 0.05)) {
        Fit one(2);
        for (std::size_t h = 0; h < H; ++h)
            if (fits[h])
                one.add(histories[h]->time_s, histories[h]->force_N,
                        {answer[h][2], relaxed(histories[h]->time_s, answer[h][2], Eigen::VectorXd::Constant(1, tau_s), Eigen::VectorXd::Ones(1))});
        if (one.left() >= least) continue;
        least = one.left();
        branch = one.best();
        table.branch[0] = branch[1] / branch.sum();
        table.branch[1] = tau_s;
    }

    for (std::size_t h = 0; h < H; ++h) {
        const History& history = *histories[h];
        const Eigen::VectorXd& t = history.time_s;
        HistoryAnswer row{history.name, history.group, history.kind, {t.begin(), t.end()}, {}, {}, {}, {}, {}};
        const Eigen::VectorXd fe = history.force_N * history.direction, own = answer[h][0] * history.direction, springs = table.factor * (answer[h][2] * history.direction);
        row.fe_N.assign(fe.begin(), fe.end());
        row.learned_N.assign(own.begin(), own.end());
        row.elastic_N.assign(springs.begin(), springs.end());
        const double nothing = std::numeric_limits<double>::quiet_NaN();
        const bool elastic = prony[h].rows() > 0;
        row.elastic = elastic ? history_error(t, history.elastic_N, answer[h][2]) : HistoryError{nothing, nothing};
        const NodeField& now = answer[h][2];
        for (const NodeField& force : {answer[h][0], answer[h][1], now, NodeField(table.factor * now), NodeField(ab[0] * now + ab[1] * rate(t, now)),
                                       NodeField(branch[0] * now + branch[1] * relaxed(t, now, Eigen::VectorXd::Constant(1, table.branch[1]), Eigen::VectorXd::Ones(1)))})
            row.error.push_back(history_error(t, history.force_N, force));
        row.error.push_back(elastic ? history_error(t, history.force_N, prony[h]) : HistoryError{nothing, nothing});
        table.answers.push_back(std::move(row));
    }
    return table;
}

int near_training(const Cases& cases, const std::string& role) {
    constexpr double near_m = 0.002;  // distance of test contacts from training contacts in every other data set
    return static_cast<int>(std::count_if(cases.histories.begin(), cases.histories.end(), [&](const History& h) {
        return h.role == role && h.lost.empty() && std::any_of(cases.paths.begin(), cases.paths.end(), [&](const LoadPath& path) {
            return path.role == "train" && (path.contact_m - h.contact_m).norm() < near_m;
        });
    }));
}

}  // namespace tissue
