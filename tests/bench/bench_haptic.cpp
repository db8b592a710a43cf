// Times of the realtime core, as JSON entries of results/bench.json on standard output.
//
//   bench_haptic [results/STUDY]     full ticks of made-up models, and of that study's model
//
// The peer is a plain explicit step in double precision: a loop over a vector of springs, and for an energy model over
// its cells and regions. Both are timed in the same run, in alternating batches. CHAI3D's GEL needs about 1.15 us for
// 220 springs; it is not built here.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "../mesh/embedded_block.h"
#include "haptic/moving_triangles.h"
#include "haptic/simulation.h"
#include "haptic/virtual_device.h"
#include "mesh/facet.h"
#include "springs/energy_model_terms.h"
#include "springs/heuristic.h"
#include "springs/region_area.h"

namespace {

using namespace tissue;
using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

double microseconds(Clock::duration d) {
    return std::chrono::duration<double, std::micro>(d).count();
}

double rank(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

Json entry(const std::string& name, const std::string& unit, const std::vector<double>& ours, const std::vector<double>& peer = {}) {
    Json j = {{"name", name}, {"unit", unit}, {"median", rank(ours, 0.5)}, {"p95", rank(ours, 0.95)}, {"n", ours.size()},
              {"peer", nullptr}, {"peer_version", nullptr}, {"peer_median", nullptr}, {"ratio", nullptr}};
    if (!peer.empty()) {
        j["peer"] = "plain loop over a spring vector";
        j["peer_version"] = "gcc " + std::to_string(__GNUC__);
        j["peer_median"] = rank(peer, 0.5);
        j["ratio"] = rank(ours, 0.5) / rank(peer, 0.5);
    }
    return j;
}

/// The time step in its simplest form.
struct PlainMesh {
    struct Spring { int i, j; double k, nx, ny; };
    struct Node { double ux, uy, vx, vy, fx, fy, inverse_mass; };
    std::vector<Spring> springs;
    std::vector<Node> nodes;

    PlainMesh(const SpringMesh& mesh, const Eigen::VectorXd& theta, const Eigen::VectorXd& mass) {
        for (int s = 0; s < mesh.spring_count(); ++s) {
            const Eigen::RowVector2d n = (mesh.nodes.row(mesh.springs(s, 1)) - mesh.nodes.row(mesh.springs(s, 0))).normalized();
            springs.push_back({mesh.springs(s, 0), mesh.springs(s, 1), theta[s], n.x(), n.y()});
        }
        for (int n = 0; n < mesh.node_count(); ++n) nodes.push_back({0, 0, 0, 0, 0, 0, 1 / mass[n]});
        for (int n : mesh.fixed) nodes[static_cast<std::size_t>(n)].inverse_mass = 0;
    }

    void step(double dt, double damping) {
        for (Node& n : nodes) n.fx = n.fy = 0;
        for (const Spring& s : springs) {
            Node &a = nodes[static_cast<std::size_t>(s.i)], &b = nodes[static_cast<std::size_t>(s.j)];
            const double pull = s.k * (s.nx * (b.ux - a.ux) + s.ny * (b.uy - a.uy));
            a.fx += pull * s.nx;
            a.fy += pull * s.ny;
            b.fx -= pull * s.nx;
            b.fy -= pull * s.ny;
        }
        for (Node& n : nodes) {
            n.vx += dt * (n.inverse_mass * n.fx - damping * n.vx);
            n.vy += dt * (n.inverse_mass * n.fy - damping * n.vy);
            n.ux += dt * n.vx;
            n.uy += dt * n.vy;
        }
    }
};

/// Microseconds per step, ours and the peer's.
struct StepTimes {
    std::vector<double> ours, peer;
    int springs;
};

StepTimes time_steps(int side, int batches) {
    const SpringMesh mesh = make_lattice("grid8", side - 1, side - 1, 0.1, 0.1);
    const Eigen::VectorXd mass = node_masses(mesh, 1040, 1.0 / 6000);
    // the time step scales with the spacing: 0.5 ms at 10 mm
    const double h = 0.1 / (side - 1), dt = 0.5 * h / 0.01 * 1e-3;
    const Eigen::VectorXd theta = heuristic_stiffness(mesh, 0.754);
    const RealtimeMesh realtime(mesh, "axial", mass);
    const auto dynamics = make_dynamics("symplectic", realtime, {dt, 1});
    MeshState state(realtime, realtime.to_slots(theta));
    PlainMesh plain(mesh, theta, mass);
    for (int n = 0; n < mesh.node_count(); ++n) {
        const double ux = 1e-3 * std::sin(0.3 * n), uy = 1e-3 * std::cos(0.7 * n);
        if (realtime.fixed(n)) continue;
        state.displacement.row(n) << ux, uy;
        plain.nodes[static_cast<std::size_t>(n)].ux = ux;
        plain.nodes[static_cast<std::size_t>(n)].uy = uy;
    }
    const int repeat = std::max(1, 40000 / mesh.spring_count());
    StepTimes times{{}, {}, mesh.spring_count()};
    for (int batch = 0; batch < batches + 3; ++batch) {
        const auto start = Clock::now();
        for (int k = 0; k < repeat; ++k) dynamics->step(state, {});
        const auto middle = Clock::now();
        for (int k = 0; k < repeat; ++k) plain.step(dt, 1);
        const auto end = Clock::now();
        if (batch < 3) continue;  // warm-up of caches and pages
        times.ours.push_back(microseconds(middle - start) / repeat);
        times.peer.push_back(microseconds(end - middle) / repeat);
    }
    double difference = 0;
    for (int n = 0; n < mesh.node_count(); ++n)
        difference = std::max(difference, std::abs(state.displacement(n, 0) - plain.nodes[static_cast<std::size_t>(n)].ux));
    if (!(difference < 1e-3)) {
        std::cerr << "bench_haptic: the two steps do not agree\n";
        std::exit(1);
    }
    return times;
}

/// The time step of an energy model in its simplest form: springs along their current direction, areas of cells and
/// regions.
struct PlainModel {
    struct Spring { int i, j; double k, length; };
    struct Ring { std::vector<int> nodes; double k, area; };
    struct Node { double x, y, vx, vy, fx, fy, inverse_mass; };
    std::vector<Spring> springs;
    std::vector<Ring> rings;
    std::vector<Node> nodes;

    explicit PlainModel(const TissueModel& m) {
        const Eigen::VectorXd& constants = m.energy_model->constants;
        for (int s = 0; s < m.mesh.spring_count(); ++s) {
            const int i = m.mesh.springs(s, 0), j = m.mesh.springs(s, 1);
            springs.push_back({i, j, constants[s], (m.mesh.nodes.row(j) - m.mesh.nodes.row(i)).norm()});
        }
        for (int n = 0; n < m.mesh.node_count(); ++n)
            nodes.push_back({m.mesh.nodes(n, 0), m.mesh.nodes(n, 1), 0, 0, 0, 0, 1 / m.node_mass_kg[n]});
        for (int n : m.mesh.fixed) nodes[static_cast<std::size_t>(n)].inverse_mass = 0;
        const TissueEnergy energy(m.mesh, m.energy_model->incompressible);
        for (std::size_t k = 1; k < energy.kinds().size(); ++k) {
            const Elements& kind = *energy.kinds()[k];
            for (int e = 0; e < kind.count(); ++e) {
                Ring ring{{}, constants[energy.first_of(k) + e], 0};
                if (kind.kind() == "cell")
                    for (Eigen::Index c = 0; c < kind.nodes().cols(); ++c) ring.nodes.push_back(kind.nodes()(e, c));
                else
                    ring.nodes = in_order(static_cast<const RegionArea&>(kind));
                ring.area = area(ring);
                rings.push_back(ring);
            }
        }
    }

    static std::vector<int> in_order(const RegionArea& region) {
        std::map<int, int> next;
        for (const auto& [i, j] : region.edges()) next[i] = j;
        std::vector<int> order;
        for (int at = 0; order.empty() || at != 0; at = next[at]) order.push_back(region.nodes()(0, at));
        return order;
    }

    double area(const Ring& ring) const {
        double twice = 0;
        for (std::size_t k = 0; k < ring.nodes.size(); ++k) {
            const Node &a = nodes[static_cast<std::size_t>(ring.nodes[k])], &b = nodes[static_cast<std::size_t>(ring.nodes[(k + 1) % ring.nodes.size()])];
            twice += a.x * b.y - a.y * b.x;
        }
        return twice / 2;
    }

    void step(double dt, double damping) {
        for (Node& n : nodes) n.fx = n.fy = 0;
        for (const Spring& s : springs) {
            Node &a = nodes[static_cast<std::size_t>(s.i)], &b = nodes[static_cast<std::size_t>(s.j)];
            const double x = b.x - a.x, y = b.y - a.y, length = std::sqrt(x * x + y * y), pull = s.k * (length - s.length) / length;
            a.fx += pull * x;
            a.fy += pull * y;
            b.fx -= pull * x;
            b.fy -= pull * y;
        }
        for (const Ring& ring : rings) {
            const double push = ring.k * (area(ring) / ring.area - 1) / 2;
            for (std::size_t k = 0, n = ring.nodes.size(); k < n; ++k) {
                const Node &before = nodes[static_cast<std::size_t>(ring.nodes[(k + n - 1) % n])], &after = nodes[static_cast<std::size_t>(ring.nodes[(k + 1) % n])];
                Node& at = nodes[static_cast<std::size_t>(ring.nodes[k])];
                at.fx -= push * (after.y - before.y);
                at.fy += push * (after.x - before.x);
            }
        }
        for (Node& n : nodes) {
            n.vx += n.inverse_mass > 0 ? dt * (n.inverse_mass * n.fx - damping * n.vx) : 0;
            n.vy += n.inverse_mass > 0 ? dt * (n.inverse_mass * n.fy - damping * n.vy) : 0;
            n.x += dt * n.vx;
            n.y += dt * n.vy;
        }
    }
};

/// The same in space: springs along their current direction, volumes of boxes, and supports at points in boxes.
struct PlainSolid {
    struct Spring { int i, j; double k, length; };
    struct Box { int corner[8]; double k, volume; };
    struct Support { int corner[8]; double weight[8], k; };
    struct Node { double x, y, z, vx, vy, vz, fx, fy, fz, inverse_mass; };
    std::vector<Spring> springs;
    std::vector<Box> boxes;
    std::vector<Support> supports;
    std::vector<Node> nodes, rest;

    explicit PlainSolid(const TissueModel& m) {
        const Eigen::VectorXd& constants = m.energy_model->constants;
        const NodeField& x = m.mesh.nodes;
        for (int s = 0; s < m.mesh.spring_count(); ++s)
            springs.push_back({m.mesh.springs(s, 0), m.mesh.springs(s, 1), constants[s], m.mesh.rest_length(s)});
        for (int n = 0; n < m.mesh.node_count(); ++n) nodes.push_back({x(n, 0), x(n, 1), x(n, 2), 0, 0, 0, 0, 0, 0, m.node_mass_kg[n] > 0 ? 1 / m.node_mass_kg[n] : 0});
        rest = nodes;
        const Cells cells = mesh_cells(m.mesh);
        for (Eigen::Index held = 0; held < m.mesh.support_count(); ++held) {
            Support support{{}, {}, constants[m.mesh.spring_count() + cells.rows() + held]};
            for (int c = 0; c < 8; ++c) {
                support.corner[c] = m.mesh.embedding.corner(m.mesh.fixed[static_cast<std::size_t>(held)], c);
                support.weight[c] = m.mesh.embedding.weight(m.mesh.fixed[static_cast<std::size_t>(held)], c);
            }
            supports.push_back(support);
        }
        for (int e = 0; e < cells.rows(); ++e) {
            Box box{{}, constants[m.mesh.spring_count() + e], 0};
            for (int c = 0; c < 8; ++c) box.corner[c] = cells(e, c);
            double edge[9];
            box.volume = volume(box, edge);
            boxes.push_back(box);
        }
    }

    /// Volume from the mean edge along each axis (3 x 3, row by axis).
    double volume(const Box& box, double* edge) const {
        for (int a = 0; a < 3; ++a) {
            double x = 0, y = 0, z = 0;
            for (int c = 0; c < 8; ++c) {
                const Node& n = nodes[static_cast<std::size_t>(box.corner[c])];
                const double sign = (c >> a & 1) ? 0.25 : -0.25;
                x += sign * n.x;
                y += sign * n.y;
                z += sign * n.z;
            }
            edge[3 * a] = x;
            edge[3 * a + 1] = y;
            edge[3 * a + 2] = z;
        }
        const double *p = edge, *q = edge + 3, *r = edge + 6;
        return p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) + p[2] * (q[0] * r[1] - q[1] * r[0]);
    }

    void step(double dt, double damping) {
        for (Node& n : nodes) n.fx = n.fy = n.fz = 0;
        for (const Spring& s : springs) {
            Node &a = nodes[static_cast<std::size_t>(s.i)], &b = nodes[static_cast<std::size_t>(s.j)];
            const double x = b.x - a.x, y = b.y - a.y, z = b.z - a.z, length = std::sqrt(x * x + y * y + z * z), pull = s.k * (length - s.length) / length;
            a.fx += pull * x;
            a.fy += pull * y;
            a.fz += pull * z;
            b.fx -= pull * x;
            b.fy -= pull * y;
            b.fz -= pull * z;
        }
        for (const Box& box : boxes) {
            double edge[9], f[9];
            const double push = box.k * (volume(box, edge) / box.volume - 1) / 4;
            for (int a = 0; a < 3; ++a) {
                const double *q = edge + 3 * ((a + 1) % 3), *r = edge + 3 * ((a + 2) % 3);
                f[3 * a] = push * (q[1] * r[2] - q[2] * r[1]);
                f[3 * a + 1] = push * (q[2] * r[0] - q[0] * r[2]);
                f[3 * a + 2] = push * (q[0] * r[1] - q[1] * r[0]);
            }
            for (int c = 0; c < 8; ++c) {
                Node& n = nodes[static_cast<std::size_t>(box.corner[c])];
                for (int a = 0; a < 3; ++a) {
                    const double sign = (c >> a & 1) ? 1 : -1;
                    n.fx -= sign * f[3 * a];
                    n.fy -= sign * f[3 * a + 1];
                    n.fz -= sign * f[3 * a + 2];
                }
            }
        }
        for (const Support& support : supports) {
            double x = 0, y = 0, z = 0;
            for (int c = 0; c < 8; ++c) {
                const Node &n = nodes[static_cast<std::size_t>(support.corner[c])], &at = rest[static_cast<std::size_t>(support.corner[c])];
                x += support.weight[c] * (n.x - at.x);
                y += support.weight[c] * (n.y - at.y);
                z += support.weight[c] * (n.z - at.z);
            }
            for (int c = 0; c < 8; ++c) {
                Node& n = nodes[static_cast<std::size_t>(support.corner[c])];
                n.fx -= support.k * support.weight[c] * x;
                n.fy -= support.k * support.weight[c] * y;
                n.fz -= support.k * support.weight[c] * z;
            }
        }
        for (Node& n : nodes) {
            if (n.inverse_mass == 0) continue;
            n.vx += dt * (n.inverse_mass * n.fx - damping * n.vx);
            n.vy += dt * (n.inverse_mass * n.fy - damping * n.vy);
            n.vz += dt * (n.inverse_mass * n.fz - damping * n.vz);
            n.x += dt * n.vx;
            n.y += dt * n.vy;
            n.z += dt * n.vz;
        }
    }
};

/// Steps of an energy model's mesh, ours and the peer's, from the same displacements.
template <class Plain>
StepTimes time_energy_model_steps(const TissueModel& m, int batches) {
    const RealtimeMesh springs(m.mesh, "geometric", m.node_mass_kg);
    const RealtimeEnergyModel energy_model(m, springs);
    constexpr double dt = 5e-4;
    const auto dynamics = make_dynamics("symplectic", springs, {dt, 1, &energy_model});
    MeshState state(springs, Eigen::VectorXd::Zero(springs.slot_count()));
    Plain plain(m);
    for (int n = 0; n < m.mesh.node_count(); ++n) {
        if (springs.fixed(n) || m.node_mass_kg[n] == 0) continue;
        state.displacement.row(n).head<2>() << 1e-3 * std::sin(0.3 * n), 1e-3 * std::cos(0.7 * n);
        plain.nodes[static_cast<std::size_t>(n)].x += state.displacement(n, 0);
        plain.nodes[static_cast<std::size_t>(n)].y += state.displacement(n, 1);
    }
    // single steps of a large mesh, for its p99
    const int repeat = m.mesh.spring_count() > 5000 ? 1 : 40000 / m.mesh.spring_count();
    StepTimes times{{}, {}, m.mesh.spring_count()};
    for (int batch = 0; batch < batches + 3; ++batch) {
        const auto start = Clock::now();
        for (int k = 0; k < repeat; ++k) dynamics->step(state, {});
        const auto middle = Clock::now();
        for (int k = 0; k < repeat; ++k) plain.step(dt, 1);
        const auto end = Clock::now();
        if (batch == 0)  // before rounding errors grow
            for (int n = 0; n < m.mesh.node_count(); ++n)
                if (m.node_mass_kg[n] > 0 && !(std::abs(m.mesh.nodes(n, 0) + state.displacement(n, 0) - plain.nodes[static_cast<std::size_t>(n)].x) < 1e-4)) {
                    std::cerr << "bench_haptic: the two steps of a law do not agree\n";
                    std::exit(1);
                }
        if (batch < 3) continue;  // warm-up of caches and pages
        times.ours.push_back(microseconds(middle - start) / repeat);
        times.peer.push_back(microseconds(end - middle) / repeat);
    }
    return times;
}

/// Steps of an energy model with three Maxwell branches in every element, alternating with the same model without.
std::pair<std::vector<double>, std::vector<double>> time_relaxing_steps(const TissueModel& elastic, int batches) {
    TissueModel relaxing = elastic;
    Relaxation& r = relaxing.energy_model->relaxation;
    r.tau_s = Eigen::Vector3d(0.05, 1, 10);
    r.contact_share = Eigen::Vector3d(0.30, 0.25, 0.20);
    r.share = r.contact_share.transpose().replicate(elastic.energy_model->constants.size(), 1);
    constexpr double dt = 5e-4;
    const RealtimeMesh springs(elastic.mesh, "geometric", elastic.node_mass_kg);
    std::vector<double> times[2];
    const RealtimeEnergyModel laws[2] = {RealtimeEnergyModel(relaxing, springs), RealtimeEnergyModel(elastic, springs)};
    std::unique_ptr<Dynamics> dynamics[2];
    std::vector<MeshState> states;
    for (int which : {0, 1}) {
        dynamics[which] = make_dynamics("symplectic", springs, {dt, 1, &laws[which]});
        states.emplace_back(springs, Eigen::VectorXd::Zero(springs.slot_count()));
        states.back().memory = laws[which].memory(dt);
        for (Eigen::Index i = 0; i < states.back().displacement.size(); ++i)
            states.back().displacement.data()[i] = 1e-5 * std::sin(static_cast<double>(i));
    }
    constexpr int steps = 100;
    for (int batch = 0; batch < batches + 3; ++batch)
        for (int which : {0, 1}) {
            const auto start = Clock::now();
            for (int k = 0; k < steps; ++k) dynamics[which]->step(states[static_cast<std::size_t>(which)], {});
            if (batch >= 3) times[which].push_back(microseconds(Clock::now() - start) / steps);
        }
    return {times[0], times[1]};
}

/// An energy model on the lattice of `surface` with the heuristic's constants, two steps per tick.
TissueModel made_up_model() {
    constexpr double thickness_m = 0.1;
    TissueModel m;
    m.study = "bench";
    m.law = "axial";
    m.mesh = make_lattice("grid8", 10, 10, 0.1, 0.1);
    m.modulus_N_m = 4524 * thickness_m;
    m.node_mass_kg = node_masses(m.mesh, 1040, thickness_m);
    m.heuristic_a = heuristic_stiffness(m.mesh, m.modulus_N_m);
    const EnergyModelTerms model_terms(m.mesh, energy_model_heuristic(m.mesh, m.modulus_N_m, "plane-strain", 12), {"spring.all"});
    const Eigen::VectorXd p = Eigen::VectorXd::Zero(1);
    m.energy_model = {model_terms.terms(), p, model_terms.constants(p), model_terms.patch(p), model_terms.incompressible()};
    m.contact_m.resize(1, 2);
    m.direction.resize(1, 2);
    m.contact_m << 0.05, 0.1;
    m.direction << 0, -1;
    m.magnitude_m = Eigen::VectorXd::Constant(1, 0.015);
    m.case_names = {"top"};
    return m;
}

/// An energy model of a block in space with `cubes` cubes along its sides and half as many in height, for a disc of
/// 7 mm radius; similar to `block3` for 10 cubes.
TissueModel made_up_solid(int cubes) {
    constexpr double modulus_Pa = 4524, radius_m = 0.007;
    TissueModel m;
    m.study = "bench";
    m.law = "geometric";
    m.mesh = embedded_block(Lattice{{cubes, cubes, cubes / 2}, {0.1, 0.1, 0.05}});
    m.modulus_N_m = modulus_Pa;
    m.node_mass_kg = node_masses(m.mesh, 1040, 1);
    m.heuristic_a = heuristic_stiffness(m.mesh, modulus_Pa);
    const EnergyModelTerms model_terms(m.mesh, solid_heuristic(m.mesh, Eigen::VectorXd::Constant(m.mesh.spring_count(), modulus_Pa),
                                                Eigen::VectorXd::Constant(mesh_cells(m.mesh).rows(), modulus_Pa), modulus_Pa, 12, radius_m), {"spring.all"});
    const Eigen::VectorXd p = Eigen::VectorXd::Zero(1);
    m.energy_model = {model_terms.terms(), p, model_terms.constants(p), model_terms.patch(p), model_terms.incompressible(), radius_m};
    m.contact_m.resize(1, 3);
    m.direction.resize(1, 3);
    m.contact_m << 0.05, 0.05, 0.05;
    m.direction << 0, 0, -1;
    m.magnitude_m = Eigen::VectorXd::Constant(1, 0.01);
    m.case_names = {"top"};
    return m;
}

/// Load cases as in the paper, with different spring sets.
TissueModel made_up() {
    TissueModel m;
    m.study = "bench";
    m.law = "axial";
    m.mesh = make_lattice("grid8", 10, 10, 0.1, 0.1);
    m.modulus_N_m = 0.754;
    m.node_mass_kg = node_masses(m.mesh, 1040, 1.0 / 6000);
    m.heuristic_a = heuristic_stiffness(m.mesh, 0.754);
    SpringSets t;
    t.optimizer = "bench";
    const double place[5][2] = {{0, 0.05}, {0, 0.1}, {0.05, 0.1}, {0.1, 0.1}, {0.1, 0.05}};
    m.contact_m.resize(20, 2);
    m.direction.resize(20, 2);
    m.magnitude_m.resize(20);
    t.theta.resize(20, m.mesh.spring_count());
    for (int c = 0; c < 20; ++c) {
        m.case_names.push_back("case-" + std::to_string(c));
        m.contact_m.row(c) << place[c / 4][0], place[c / 4][1];
        const double angle = -1.2 - 0.7 * (c / 2 % 2);
        m.direction.row(c) << std::cos(angle), std::sin(angle);
        m.magnitude_m[c] = c % 2 ? 0.015 : 0.010;
        for (int s = 0; s < m.mesh.spring_count(); ++s) t.theta(c, s) = m.heuristic_a[s] * (1 + 0.3 * std::sin(1.7 * s + 2.3 * c));
    }
    m.trained = {t};
    return m;
}

/// Microseconds of every tick in 20 s of indenting, dragging and releasing: one or two meshes, contact, spring sets
/// with their moving average or an energy model, safety.
std::vector<double> time_ticks(const TissueModel& tissue, const std::string& dynamics, bool heuristic_mesh) {
    HapticOptions o;
    o.dynamics = dynamics;
    o.heuristic_mesh = heuristic_mesh;
    const HapticModel model(tissue, o);
    Simulation simulation(model);
    VirtualDevice hand(make_motion({"slide", 20, 0.01, 1, &model.rest}), o.map);
    std::vector<double> times;
    for (int k = 0; k < 20000; ++k) {
        const DeviceSample sample = hand.read(k * 1e-3);
        const auto start = Clock::now();
        simulation.tick(sample);
        const auto end = Clock::now();
        if (k >= 100) times.push_back(microseconds(end - start));
    }
    return times;
}

/// Microseconds of every tick in 20 s in which two tools 40 mm apart indent, drag and release (ours), and with one tool
/// alone (peer), tick by tick.
StepTimes time_tools(const TissueModel& tissue) {
    const auto with = [&](int tools) {
        HapticOptions o;
        o.heuristic_mesh = false;
        o.tools = tools;
        return std::make_unique<HapticModel>(tissue, o);
    };
    const std::unique_ptr<HapticModel> two = with(2), one = with(1);
    Simulation both(*two), alone(*one);
    VirtualDevice hand(make_motion({"slide", 20, 0.01, 1, &two->rest}), two->options.map);
    StepTimes times;
    for (int k = 0; k < 20000; ++k) {
        DeviceSample samples[most_tools] = {hand.read(k * 1e-3), {}};
        samples[1].position_m = samples[0].position_m;
        samples[0].position_m.y() -= 0.02;
        samples[1].position_m.y() += 0.02;
        Eigen::Vector3d forces_N[most_tools];
        const auto start = Clock::now();
        both.tick(samples, forces_N);
        const auto middle = Clock::now();
        alone.tick(samples[0]);
        const auto end = Clock::now();
        if (k < 100) continue;
        times.ours.push_back(microseconds(middle - start));
        times.peer.push_back(microseconds(end - middle));
    }
    return times;
}

/// Time of all surface queries of a tick in space, while an indentation grows and decays (ours); and of the nearest
/// point alone by a loop over every triangle (peer).
StepTimes time_triangles() {
    const SpringMesh mesh = embedded_block(Lattice{{15, 15, 9}, {0.1, 0.1, 0.05}});
    MovingTriangles surface(mesh);
    const NodeColumns rest = mesh.nodes;
    NodeColumns u = NodeColumns::Zero(rest.rows(), 3);
    const Point place = Point::Zero(3);
    StepTimes times;
    times.springs = surface.triangles();
    for (int tick = 0; tick < 20000; ++tick) {
        const double depth_m = 0.008 * std::abs(std::sin(0.01 * tick)), x = 0.05 + 0.01 * std::sin(0.1 * tick);
        for (Eigen::Index n = 0; n < rest.rows(); ++n)
            u(n, 2) = -depth_m * std::exp(-(rest.row(n) - Eigen::RowVector3d(0.05, 0.05, 0.05)).squaredNorm() / 2e-4);
        const Point above = Eigen::Vector3d(x, 0.05, 0.0501), below = Eigen::Vector3d(x, 0.051, 0.035);
        int used = 0;
        const auto start = Clock::now();
        surface.move(place, rest, u);
        used += surface.simple();
        used += surface.contains(below) + surface.contains_strictly(above, 1e-9);
        used += surface.nearest(below).facet;
        used += surface.first_crossing(above, below).has_value();
        const auto end = Clock::now();
        if (tick >= 100) times.ours.push_back(microseconds(end - start));
        if (tick % 100 > 0) continue;
        const NodeField now = rest + u;
        double least = 1;
        const auto plain = Clock::now();
        for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) least = std::min(least, nearest_on_facet(now, mesh.facets, f, below).distance_m);
        times.peer.push_back(microseconds(Clock::now() - plain));
        if (used < 0 || least < 0) throw std::logic_error("no distance is below 0");
    }
    return times;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        Json list = Json::array();
        const StepTimes small = time_steps(11, 3000);
        list.push_back(entry("haptic: mesh step, 11 x 11 grid8 axial, 420 springs", "us", small.ours, small.peer));
        const TissueModel law = made_up_model();
        const StepTimes energy_model_step = time_energy_model_steps<PlainModel>(law, 3000);
        list.push_back(entry("haptic: mesh step, 11 x 11 grid8 law, 420 springs, 100 cells, 5 regions", "us", energy_model_step.ours, energy_model_step.peer));
        const auto [relaxing, elastic] = time_relaxing_steps(law, 3000);
        list.push_back(entry("haptic: the same with three branches, beside it without", "us", relaxing, elastic));
        const StepTimes triangles = time_triangles();
        list.push_back(entry("haptic: surface of " + std::to_string(triangles.springs) + " triangles, a tick's use", "us", triangles.ours, triangles.peer));
        list.back()["peer"] = "nearest point alone, triangle by triangle";
        list.push_back(entry("haptic: surface of " + std::to_string(triangles.springs) + " triangles, a tick's use, p99", "us", {rank(triangles.ours, 0.99)}));
        list.back()["n"] = triangles.ours.size();
        for (const int cubes : {10, 20}) {
            const TissueModel solid = made_up_solid(cubes);
            const StepTimes step = time_energy_model_steps<PlainSolid>(solid, 3000);
            const std::string name = "haptic: mesh step, " + std::to_string(cubes + 1) + " x " + std::to_string(cubes + 1) + " x " + std::to_string(cubes / 2 + 1) + " law in space, " +
                                     std::to_string(step.springs) + " springs, " + std::to_string(mesh_cells(solid.mesh).rows()) + " volumes";
            list.push_back(entry(name, "us", step.ours, step.peer));
            list.push_back(entry(name + ", p99", "us", {rank(step.ours, 0.99)}));
        }
        std::vector<std::pair<std::string, TissueModel>> models = {{"grid8 axial", made_up()}, {"grid8 law", law}, {"law in space", made_up_solid(10)}};
        if (argc > 1) {
            models.emplace_back("", read_model(std::string(argv[1]) + "/model.h5"));
            models.back().first = "study " + models.back().second.study;
        }
        for (const auto& [model, tissue] : models)
            for (const std::string dynamics : {"symplectic", "implicit"})
                for (const bool two : {true, false}) {
                    // an energy model has no implicit step
                    if (tissue.energy_model ? dynamics == "implicit" : !two) continue;
                    const std::vector<double> ticks = time_ticks(tissue, dynamics, two);
                    const std::string name = std::string("haptic: full tick, ") + (two ? "two meshes, " : "one mesh, ") + model + ", " + dynamics;
                    list.push_back(entry(name, "us", ticks));
                    list.push_back(entry(name + ", p99", "us", {rank(ticks, 0.99)}));
                    list.back()["n"] = ticks.size();
                }
        const StepTimes tools = time_tools(made_up_solid(10));
        list.push_back(entry("haptic: full tick, two tools, law in space", "us", tools.ours, tools.peer));
        list.back()["peer"] = "one tool";
        for (int side : {11, 21, 41, 81, 161, 301}) {
            StepTimes t = time_steps(side, side > 100 ? 60 : 300);
            for (double& us : t.ours) us *= 1e3 / t.springs;
            for (double& us : t.peer) us *= 1e3 / t.springs;
            list.push_back(entry("haptic: time per spring, " + std::to_string(side) + " x " + std::to_string(side) + " nodes", "ns", t.ours, t.peer));
        }
        // the largest lattice whose median step takes less than a period
        int fits = 11, too_large = 2001;
        while (too_large - fits > 10) {
            const int side = (fits + too_large) / 2;
            (rank(time_steps(side, 40).ours, 0.5) < 1000 ? fits : too_large) = side;
        }
        list.push_back(entry("haptic: largest lattice whose median step fits 1 ms, nodes a side", "nodes", {static_cast<double>(fits)}));
        std::cout << list.dump(1) << '\n';
    } catch (const std::exception& e) {
        std::cerr << "bench_haptic: " << e.what() << '\n';
        return 1;
    }
    return 0;
}
