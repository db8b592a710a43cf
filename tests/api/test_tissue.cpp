// The C interface: the same ticks as in the library, errors as codes with a line of text, no exceptions, no allocation
// in the tick.
#include "api/tissue.h"

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cfenv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <thread>

#include "../allocations.h"
#include "../example.h"
#include "../float_mode.h"
#include "../haptic/haptic_example.h"
#include "../refusal.h"
#include "../springs/several_discs.h"
#include "error.h"
#include "haptic/session_options.h"
#include "haptic/tick_clock.h"
#include "mesh/nodule_surface.h"
#include "version.h"

using namespace tissue;

namespace {

struct Session {
    tissue_session* s = nullptr;
    Session(const std::string& file, std::initializer_list<const char*> options = {}) {
        std::vector<const char*> list(options);
        list.push_back(nullptr);
        const tissue_status status = tissue_open(file.c_str(), list.data(), &s);
        INFO(file << ": " << tissue_error());
        REQUIRE(status == TISSUE_OK);
    }
    ~Session() { tissue_close(&s); }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
};

std::string model_file(const TemporaryFolder& folder, const TissueModel& model) {
    const std::string file = folder.file("model.h5");
    write_model(file, model, {"test", 1, {}});
    return file;
}

/// Path of the device: indentation, motion along the surface, and withdrawal.
Eigen::Vector3d way(int k, bool solid) {
    const double t = 1e-3 * k, deep = 0.006 * std::sin(3.14 * t);
    return solid ? Eigen::Vector3d(0.03 + 0.002 * std::sin(9 * t), 0.03, 0.051 - deep) : Eigen::Vector3d(0.05 + 0.004 * std::sin(9 * t), 0.101 - deep, 0.3);
}

}  // namespace

TEST_CASE("a session in C has the forces of the library bit for bit and the same state", "[api]") {
    for (const int which : {0, 1, 2}) {
        const TemporaryFolder folder;
        const TissueModel model = which == 0 ? haptic_example() : which == 1 ? relaxing(energy_model_example()) : solid_example();
        const std::string file = model_file(folder, model);
        const bool solid = which == 2;
        HapticOptions options;
        options.heuristic_mesh = false;
        options.friction.stick = 0.4;
        options.map.force_scale = 2;
        const HapticModel haptic(model, options);
        Simulation simulation(haptic);
        Session session(file, {"friction", "0.4", "force-scale", "2"});
        REQUIRE(tissue_dimension(session.s) == model.mesh.dimension());
        REQUIRE(tissue_node_count(session.s) == model.mesh.node_count());
        REQUIRE(tissue_facet_count(session.s) == model.mesh.facets.rows());
        CHECK(tissue_study(session.s) == model.study);
        CHECK(tissue_tool_radius(session.s) == (model.energy_model ? model.energy_model->disc_radius_m : 0));
        CHECK(tissue_tool_shape(session.s) == std::string(solid ? "disc" : ""));
        const int N = model.mesh.node_count(), D = model.mesh.dimension();
        int different = 0;
        double largest = 0;
        long allocations = 0;
        int skinned = 0;
        for (int k = 0; k < 1000; ++k) {
            if (k == 700) {
                simulation.reset();
                CHECK(tissue_reset(session.s) == TISSUE_OK);
            }
            const Eigen::Vector3d at = k == 300 ? Eigen::Vector3d(std::nan(""), 0, 0) : way(k, solid);
            const double elapsed = k % 50 == 7 ? 0.003 : 0;
            DeviceSample sample;
            sample.position_m = at;
            const Eigen::Vector3d expected = simulation.tick(sample, elapsed);
            Eigen::Vector3d force(1, 1, 1);
            tissue_status status;
            {
                const Allocations none;
                status = tissue_tick(session.s, at.data(), elapsed, force.data());
                allocations += Allocations::count();
            }
            const TickStatus came_to = simulation.record().status;
            CHECK(status == (k == 300 ? TISSUE_FAULT : came_to == TickStatus::not_armed ? TISSUE_NOT_ARMED : TISSUE_OK));
            CHECK((k >= 300 || came_to == TickStatus::done));
            if (k == 200 || k == 999) {  // in contact, and after withdrawal
                NodeField shown(N, D);
                {
                    const Allocations none;
                    status = tissue_positions(session.s, shown.data());
                    allocations += Allocations::count();
                }
                CHECK(status == TISSUE_OK);
                NodeColumns seen;
                simulation.displayed(0, seen);
                CHECK(shown == NodeField(model.mesh.nodes + seen));
                if (k == 200) skinned += seen != simulation.state(0).displacement;
            }
            different += std::memcmp(force.data(), expected.data(), 3 * sizeof(double)) != 0;
            largest = std::max(largest, force.norm());
        }
        INFO(model.study << " " << which);
        CHECK(different == 0);
        CHECK(largest > (which == 0 ? 0.002 : 0.05));
        CHECK(allocations == 0);
        CHECK(skinned == solid);
        NodeField rest(N, D), now(N, D);
        CHECK(tissue_rest_positions(session.s, rest.data()) == TISSUE_OK);
        CHECK(tissue_positions(session.s, now.data()) == TISSUE_OK);
        CHECK(rest == model.mesh.nodes);
        CHECK(now == NodeField(model.mesh.nodes + simulation.state(0).displacement));
        Cells facets(model.mesh.facets.rows(), model.mesh.facets.cols());
        CHECK(tissue_facets(session.s, facets.data()) == TISSUE_OK);
        CHECK(facets == Cells(model.mesh.facets));
        tissue_contact contact;
        CHECK(tissue_read_contact(session.s, &contact, sizeof contact) == TISSUE_OK);
        CHECK(contact.mesh == simulation.record().mesh);
        CHECK(contact.force_N[D - 1] == -simulation.record().coupling_N[D - 1]);
        CHECK((D == 3 || contact.force_N[2] == 0));
        CHECK((tissue_stiffness(session.s) == std::string("law")) == (which > 0));
        long long ticks = 0, bad = 0;
        CHECK(tissue_count(session.s, "ticks", &ticks) == TISSUE_OK);
        CHECK(tissue_count(session.s, "bad_input", &bad) == TISSUE_OK);
        CHECK(ticks == 1000);
        CHECK(bad == 1);
        double given_J = 0;
        CHECK(tissue_energy(session.s, "given", &given_J) == TISSUE_OK);
        CHECK(given_J == simulation.safety().counters().energy_given_J);
    }
}

TEST_CASE("surfaces of boundary and nodule and an added organ move with the tissue", "[api][solid]") {
    const TemporaryFolder folder;
    TissueModel model = solid_example();
    const Eigen::RowVector3d low = model.mesh.nodes.colwise().minCoeff(), high = model.mesh.nodes.colwise().maxCoeff(), middle = (low + high) / 2;
    model.nodule = nodule_surface(Inclusion(middle.transpose(), 0.006));
    Session session(model_file(folder, model));
    const int V = tissue_surface_points(session.s, "boundary"), W = tissue_surface_triangles(session.s, "boundary");
    REQUIRE(W == model.mesh.facets.rows());
    REQUIRE(V > 50);
    CHECK(tissue_surface_points(session.s, "nodule") == model.nodule.points.rows());
    CHECK(tissue_surface_points(session.s, "organ") == 0);

    // the triangles of the boundary, scaled by 1.01 and in millimetres
    Cells triangles(W, 3);
    NodeField rest(V, 3);
    CHECK(tissue_surface(session.s, "boundary", triangles.data(), rest.data()) == TISSUE_OK);
    CHECK((triangles.minCoeff() == 0 && triangles.maxCoeff() == V - 1));
    std::string obj;
    for (const auto& p : rest.rowwise()) {
        const Eigen::RowVector3d at = 1e3 * (middle + 1.01 * (p - middle));
        obj += fmt::format("v {} {} {}\n", at.x(), at.y(), at.z());
    }
    for (const auto& t : triangles.rowwise()) obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    const std::string file = folder.file("organ.obj", obj);
    CHECK(tissue_add_surface(session.s, "organ", file.c_str(), 1) == TISSUE_MISMATCH);
    CHECK_THAT(tissue_error(), Catch::Contains("organ.obj: is up to"));
    CHECK(tissue_add_surface(session.s, "organ", file.c_str(), 1e-3) == TISSUE_OK);
    CHECK(tissue_add_surface(session.s, "organ", file.c_str(), 1e-3) == TISSUE_MISMATCH);
    CHECK(tissue_add_surface(session.s, "boundary", file.c_str(), 1e-3) == TISSUE_MISMATCH);
    CHECK(tissue_add_surface(session.s, "", file.c_str(), 1e-3) == TISSUE_MISMATCH);
    CHECK(tissue_add_surface(session.s, "other", file.c_str(), std::nan("")) == TISSUE_MISMATCH);
    CHECK(tissue_add_surface(session.s, "other", folder.file("none.obj").c_str(), 1e-3) == TISSUE_BAD_FILE);
    CHECK(tissue_surface(session.s, "other", nullptr, rest.data()) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_surface(nullptr, "boundary", nullptr, nullptr) == TISSUE_BAD_ARGUMENT);
    REQUIRE(tissue_surface_points(session.s, "organ") == V);
    NodeField organ_rest(V, 3);
    CHECK(tissue_surface(session.s, "organ", nullptr, organ_rest.data()) == TISSUE_OK);
    const NodeField larger = (1.01 * (rest.rowwise() - middle)).rowwise() + middle;
    // boundary point from which a point of the organ was made
    std::vector<Eigen::Index> of(static_cast<std::size_t>(V));
    for (Eigen::Index v = 0; v < V; ++v) CHECK((larger.rowwise() - organ_rest.row(v)).rowwise().norm().minCoeff(&of[static_cast<std::size_t>(v)]) < 1e-7);

    for (int k = 0; k < 400; ++k) {
        double force[3];
        tissue_tick(session.s, way(k, true).data(), 0, force);
    }
    NodeField nodes(tissue_node_count(session.s), 3), boundary(V, 3), organ(V, 3), nodule(model.nodule.points.rows(), 3);
    CHECK(tissue_positions(session.s, nodes.data()) == TISSUE_OK);
    {
        const Allocations none;
        tissue_surface(session.s, "boundary", nullptr, boundary.data());
        tissue_surface(session.s, "organ", nullptr, organ.data());
        tissue_surface(session.s, "nodule", nullptr, nodule.data());
        CHECK(Allocations::count() == 0);
    }
    double farthest = 0;
    for (Eigen::Index v = 0; v < V; ++v) {
        Eigen::Index same = 0;
        CHECK((model.mesh.nodes.rowwise() - rest.row(v)).rowwise().norm().minCoeff(&same) == 0);
        CHECK((boundary.row(v) - nodes.row(same)).norm() < 1e-15);
        farthest = std::max(farthest, (boundary.row(v) - rest.row(v)).norm());
    }
    CHECK(farthest > 2e-3);
    double off = 0, most = 0;  // a point of the organ moves with the nearest boundary point
    for (Eigen::Index v = 0; v < V; ++v) {
        const Eigen::Index same = of[static_cast<std::size_t>(v)];
        off = std::max(off, ((organ - organ_rest).row(v) - (boundary - rest).row(same)).norm());
        most = std::max(most, (organ - organ_rest).row(v).norm());
    }
    CHECK(most > 0.8 * farthest);
    CHECK(off < 0.2 * farthest);
    const Eigen::RowVector3d moved = (nodule - model.nodule.points).colwise().mean();
    CHECK(moved.z() < -1e-5);  // indented from above
    CHECK(moved.norm() < farthest);

    tissue_session* copy = nullptr;
    REQUIRE(tissue_copy(session.s, &copy) == TISSUE_OK);
    NodeField again(V, 3);
    CHECK(tissue_surface(copy, "organ", nullptr, again.data()) == TISSUE_OK);
    CHECK(again == organ);
    tissue_close(&copy);

    const TemporaryFolder other;
    Session plane(model_file(other, energy_model_example()));
    CHECK(tissue_surface_points(plane.s, "boundary") == 0);
    CHECK(tissue_add_surface(plane.s, "organ", file.c_str(), 1e-3) == TISSUE_MISMATCH);
}

TEST_CASE("the C interface states the version of the library", "[api]") { CHECK(std::string(tissue_version()) == version); }

TEST_CASE("invalid arguments of the C interface give an error code and one line of text", "[api]") {
    const TemporaryFolder folder;
    const std::string file = model_file(folder, energy_model_example());
    tissue_session* s = nullptr;
    CHECK(tissue_open((folder.file("nothing.h5")).c_str(), nullptr, &s) == TISSUE_BAD_FILE);
    CHECK(std::string(tissue_error()).find("nothing.h5") != std::string::npos);
    CHECK(s == nullptr);
    const auto opened = [&](std::vector<const char*> options) {
        options.push_back(nullptr);
        const tissue_status status = tissue_open(file.c_str(), options.data(), &s);
        INFO(tissue_error());
        CHECK(std::string(tissue_error()).find('\n') == std::string::npos);
        if (status == TISSUE_OK) tissue_close(&s);
        s = nullptr;
        return status;
    };
    CHECK(opened({}) == TISSUE_OK);
    CHECK(opened({"colour", "red"}) == TISSUE_BAD_ARGUMENT);
    CHECK(std::string(tissue_error()).find("'colour'") != std::string::npos);
    CHECK(opened({"friction"}) == TISSUE_BAD_ARGUMENT);
    CHECK(opened({"friction", "a lot"}) == TISSUE_BAD_ARGUMENT);
    CHECK(opened({"heuristic", "1"}) == TISSUE_BAD_ARGUMENT);
    CHECK(opened({"axes", "x,w"}) == TISSUE_BAD_ARGUMENT);
    CHECK(opened({"offset", "1"}) == TISSUE_BAD_ARGUMENT);
    CHECK(opened({"sets", "optimum"}) == TISSUE_MISMATCH);
    // options without effect
    CHECK(opened({"energy-book", "yes"}) == TISSUE_MISMATCH);
    for (const char* option : {"innovation", "coupling"}) {
        CHECK(opened({option, "0.5"}) == TISSUE_MISMATCH);
        CHECK(std::string(tissue_error()).find(option) == 0);
    }
    CHECK(opened({"coupling", "5", "heuristic", "yes"}) == TISSUE_OK);  // coupling of the heuristic mesh
    CHECK(opened({"friction-slip", "0.2"}) == TISSUE_MISMATCH);
    CHECK(opened({"dynamics", "euler"}) == TISSUE_BAD_ARGUMENT);
    CHECK(opened({"dynamics", "a\nb\x1b[31m"}) == TISSUE_BAD_ARGUMENT);
    CHECK(std::string(tissue_error()).find("'a?b?[31m'") != std::string::npos);
    CHECK(opened({"axes", "x,-z", "offset", "0 0.1", "heuristic", "yes", "passivity", "no", "dt", "0.0005"}) == TISSUE_OK);
    // every option at extreme values: refused, or the force of the session is finite
    const std::string small = folder.file("small.h5");
    write_model(small, energy_model_example(make_lattice("grid8", 4, 4, 0.1, 0.1)), {"tissuectl test", 0, {}});
    for (const SessionOption& option : session_options())
        for (const char* worst : {"nan", "inf", "-inf", "-1", "0", "1e308", "1e-308", ""}) {
            std::vector<const char*> options{option.name, worst, nullptr};
            if (tissue_open(small.c_str(), options.data(), &s) != TISSUE_OK) continue;
            for (int k = 0; k < 50; ++k) {
                double force[3];
                tissue_tick(s, way(10 * k, false).data(), 0, force);
                INFO(option.name << " = " << worst);
                REQUIRE((std::isfinite(force[0]) && std::isfinite(force[1]) && std::isfinite(force[2])));
            }
            tissue_close(&s);
        }
    s = nullptr;
    CHECK(tissue_open(nullptr, nullptr, &s) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_open(file.c_str(), nullptr, nullptr) == TISSUE_BAD_ARGUMENT);
    double three[3] = {0, 0, 0};
    long long count = 0;
    CHECK(tissue_tick(nullptr, three, 0, three) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_reset(nullptr) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_positions(nullptr, three) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_rest_positions(nullptr, three) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_facets(nullptr, nullptr) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_read_contact(nullptr, nullptr, 0) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_node_count(nullptr) == 0);
    CHECK(std::string(tissue_stiffness(nullptr)).empty());
    tissue_close(nullptr);
    Session session(file);
    // also before the first tick
    CHECK(tissue_stiffness(session.s) == std::string("law"));
    const TissueModel sets = haptic_example();
    const std::string sets_file = folder.file("sets.h5");
    write_model(sets_file, sets, {"test", 1, {}});
    CHECK(tissue_stiffness(Session(sets_file).s) == sets.case_names.front());
    CHECK(tissue_read_limits(nullptr, nullptr, 0) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_read_limits(session.s, nullptr, 8) == TISSUE_BAD_ARGUMENT);
    // a refused call sets the force to zero
    for (tissue_session* given : {session.s, static_cast<tissue_session*>(nullptr)}) {
        double force[3] = {1, 2, 3};
        CHECK(tissue_tick(given, given ? nullptr : three, 0, force) == TISSUE_BAD_ARGUMENT);
        CHECK((force[0] == 0 && force[1] == 0 && force[2] == 0));
    }
    CHECK(tissue_tick(session.s, three, 0, nullptr) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_count(session.s, "sheep", &count) == TISSUE_BAD_ARGUMENT);
    const double outside[3] = {0.05, 0.2, 0};
    for (double wrong : {std::nan(""), -1.0, std::numeric_limits<double>::infinity()}) {
        const tissue_status status = tissue_tick(session.s, outside, wrong, three);
        CHECK((status == TISSUE_OK || status == TISSUE_OVERRUN));  // an overrun if the machine paused in between
    }
    // the error text belongs to the thread
    std::string there = "unset";
    std::thread([&] { there = tissue_error(); }).join();
    CHECK(there.empty());
}

TEST_CASE("a tick preserves the caller's floating-point mode and does not depend on it", "[api]") {
    const TemporaryFolder folder;
    const std::string file = model_file(folder, energy_model_example());
    Session usual(file), other(file);
    for (int k = 0; k < 600; ++k) {
        const Eigen::Vector3d at = way(k, false);  // in the usual mode
        double expected[3], force[3];
        CHECK(tissue_tick(usual.s, at.data(), 0, expected) == TISSUE_OK);
        std::fenv_t before;
        std::fegetenv(&before);
        std::fesetround(FE_UPWARD);
        const FloatMode mine = float_mode();
        const tissue_status status = tissue_tick(other.s, at.data(), 0, force);
        const FloatMode after = float_mode();
        std::fesetenv(&before);
        REQUIRE(status == TISSUE_OK);
        REQUIRE(after == mine);
        REQUIRE(std::memcmp(force, expected, sizeof force) == 0);
    }
}

TEST_CASE("sessions of one model can be saved and restored and copied and changed and taken over", "[api]") {
    const TemporaryFolder folder;
    const TissueModel soft = relaxing(energy_model_example());
    TissueModel stiff = energy_model_example();
    stiff.energy_model->constants *= 1.5;
    const std::string file = model_file(folder, soft), other_file = folder.file("stiff.h5");
    write_model(other_file, stiff, {"test", 1, {}});
    tissue_model *model = nullptr, *other = nullptr;
    const char* options[] = {"friction", "0.3", "energy-book", "yes", nullptr};
    REQUIRE(tissue_open_model(file.c_str(), options, &model) == TISSUE_OK);
    REQUIRE(tissue_open_model(other_file.c_str(), nullptr, &other) == TISSUE_OK);
    tissue_session *a = nullptr, *b = nullptr, *copy = nullptr;
    REQUIRE(tissue_begin(model, &a) == TISSUE_OK);
    REQUIRE(tissue_begin(model, &b) == TISSUE_OK);
    const auto ticks = [](tissue_session* s, int from, int to) {
        std::vector<double> forces;
        for (int k = from; k < to; ++k) {
            double force[3];
            tissue_tick(s, way(k, false).data(), 0, force);
            forces.insert(forces.end(), force, force + 3);
        }
        return forces;
    };
    ticks(a, 0, 300);
    std::vector<char> state(tissue_state_size(a));
    REQUIRE(!state.empty());
    CHECK(tissue_save(a, state.data(), state.size() - 1) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_save(a, state.data(), state.size()) == TISSUE_OK);
    CHECK(tissue_copy(a, &copy) == TISSUE_OK);
    const std::vector<double> went_on = ticks(a, 300, 600);
    CHECK(ticks(copy, 300, 600) == went_on);
    CHECK(tissue_restore(b, state.data(), state.size()) == TISSUE_OK);
    CHECK(ticks(b, 300, 600) == went_on);
    state.back() = static_cast<char>(state.back() ^ 1);
    CHECK(tissue_restore(b, state.data(), state.size()) == TISSUE_MISMATCH);
    CHECK(std::string(tissue_error()).find("damaged") != std::string::npos);
    for (const char* name : {"given", "observed", "bound", "kinetic", "friction", "stored", "dissipated"}) {
        double energy = std::nan("");
        CHECK(tissue_energy(a, name, &energy) == TISSUE_OK);
        CHECK(std::isfinite(energy));
        if (name == std::string("friction") || name == std::string("dissipated")) CHECK(energy > 0);
    }
    double energy = 0;
    CHECK(tissue_energy(a, "potential", &energy) == TISSUE_BAD_ARGUMENT);

    // changes during a session
    CHECK(tissue_set(a, "friction", "0.1") == TISSUE_OK);
    CHECK(tissue_set(a, "friction", "-0.1") == TISSUE_MISMATCH);
    CHECK(tissue_set(a, "friction", "a lot") == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_set(a, "dt", "0.002") == TISSUE_BAD_ARGUMENT);
    CHECK(std::string(tissue_error()).find("'dt' cannot change") != std::string::npos);
    CHECK(tissue_set(a, "rotation", "0 0 0.001") == TISSUE_OK);
    CHECK(tissue_set(a, "device-mass", "0.001") == TISSUE_MISMATCH);
    CHECK(tissue_clutch(a, 1) == TISSUE_OK);
    for (int k = 0; k < 50; ++k) ticks(a, 600, 601);
    double force[3] = {1, 1, 1}, at[3] = {way(600, false).x(), way(600, false).y(), way(600, false).z()};
    CHECK(tissue_tick_aged(a, at, 0.001, 0, force) == TISSUE_OK);
    CHECK((force[0] == 0 && force[1] == 0 && force[2] == 0));
    for (const double old : {0.06, std::nan(""), std::numeric_limits<double>::infinity()}) CHECK(tissue_tick_aged(a, at, old, 0, force) == TISSUE_FAULT);

    // another model takes over with the tool in contact; then the handle of the first model is closed
    ticks(b, 600, 601);
    long long before = 0, after = 0;
    CHECK(tissue_count(b, "ticks", &before) == TISSUE_OK);
    double last[3], first[3];
    CHECK(tissue_tick(b, at, 0, last) == TISSUE_OK);
    tissue_session* next = nullptr;
    CHECK(tissue_follow(other, b, &next) == TISSUE_OK);
    CHECK(tissue_take_over(next, next) == TISSUE_BAD_ARGUMENT);
    {
        const Allocations none;
        CHECK(tissue_take_over(next, b) == TISSUE_OK);
        CHECK(Allocations::count() == 0);
    }
    tissue_close(&b);
    b = next;
    CHECK(tissue_tick(b, at, 0, first) == TISSUE_OK);
    CHECK(std::hypot(first[0] - last[0], first[1] - last[1]) < 0.01);
    CHECK(tissue_count(b, "ticks", &after) == TISSUE_OK);
    CHECK(after == before + 2);
    tissue_close_model(&model);
    tissue_close_model(&model);
    tissue_close_model(&other);
    CHECK(model == nullptr);
    tissue_session* fourth = nullptr;
    CHECK(tissue_begin(nullptr, &fourth) == TISSUE_BAD_ARGUMENT);
    ticks(a, 0, 100), ticks(b, 600, 700), ticks(copy, 600, 700);
    for (tissue_session** s : {&a, &b, &copy}) {
        tissue_close(s);
        CHECK(*s == nullptr);
        tissue_close(s);  // closing twice has no effect
    }
    tissue_close(nullptr);
    tissue_close_model(nullptr);
    CHECK(tissue_state_size(nullptr) == 0);
    CHECK(tissue_save(nullptr, state.data(), 0) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_restore(nullptr, state.data(), 0) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_copy(nullptr, &a) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_set(nullptr, "scale", "1") == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_clutch(nullptr, 1) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_follow(nullptr, nullptr, nullptr) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_take_over(nullptr, nullptr) == TISSUE_BAD_ARGUMENT);
}

TEST_CASE("slow ticks of a C host stay short and lose tissue time; a replay loses none", "[api][long]") {
    const TemporaryFolder folder;
    const std::string file = model_file(folder, energy_model_example(make_lattice("grid8", 16, 16, 0.1, 0.1)));
    using Clock = std::chrono::steady_clock;
    const double at[3] = {0.05, 0.098, 0};
    struct Run {
        double median_s;
        long long lost_ms;
    };
    // elapsed_s: of the first tick, or of every one
    const auto play = [&](double dt_s, double elapsed_s, bool by_the_clock) {
        const std::string dt = fmt::format("{}", dt_s);
        const Session session(file, {"dt", dt.c_str()});
        std::vector<double> took;
        for (Clock::time_point begin = Clock::now(), last = begin; took.size() < 40 || last - begin < std::chrono::milliseconds(300);) {
            double force[3];
            tissue_tick(session.s, at, elapsed_s, force);
            const Clock::time_point now = Clock::now();
            took.push_back(std::chrono::duration<double>(now - last).count());
            if (by_the_clock) elapsed_s = took.back();
            last = now;
        }
        std::nth_element(took.begin(), took.begin() + static_cast<long>(took.size() / 2), took.end());
        Run run{took[took.size() / 2], -1};
        CHECK(tissue_count(session.s, "lost_ms", &run.lost_ms) == TISSUE_OK);
        return run;
    };
    Run usual{}, late{}, replay{};
    for (int tries = 0; tries < 3; ++tries) {  // a busy machine may interrupt a run for longer than that
        usual = play(1e-6, 0, false);
        // a tenth of the cost of a tick: the time owed grows tenfold a tick until the clock limits it
        const double dt_s = std::max(1e-6, usual.median_s / 10);
        late = play(dt_s, dt_s, true), replay = play(dt_s, 2 * dt_s, false);
        if (late.median_s < 2 * usual.median_s && late.lost_ms > 50) break;
    }
    INFO(1e6 * usual.median_s << " us a tick of one step; late: " << 1e6 * late.median_s << " us a tick, " << late.lost_ms << " ms lost; replay: " << 1e6 * replay.median_s << " us a tick");
    CHECK(late.median_s < 2 * usual.median_s);
    CHECK(late.lost_ms > 50);
    CHECK(replay.lost_ms == 0);
}

TEST_CASE("hosts from 40 Hz or with a holding device from 10 Hz get the same force at rest", "[api]") {
    for (const TissueModel& tissue : {haptic_example(), energy_model_example()}) {
        HapticOptions holds = interface_options();
        holds.safety.hold_s = std::numeric_limits<double>::infinity();
        const HapticModel usual(tissue, interface_options()), for_ever(tissue, holds);
        const auto force_at = [&](double rate_Hz, bool says, double strays = 0) {
            Simulation s(rate_Hz < 40 ? for_ever : usual);
            TickClock clock;
            const double period_s = 1 / rate_Hz;
            double before_s = 0;
            Eigen::Vector3d force;
            for (int k = 0; k * period_s < 4; ++k) {
                const double time_s = (k + strays * (k % 3 - 1)) * period_s, in = std::clamp(time_s / 0.5, 0.0, 1.0);
                DeviceSample sample;
                sample.position_m = Eigen::Vector3d(0.05, 0.102 - 0.006 * in * in * (3 - 2 * in), 0);
                const TickClock::Start start = clock.start_at(says ? (k == 0 ? period_s : time_s - before_s) : std::nan(""), 17 + time_s);
                before_s = time_s;
                force = s.tick(sample, start.elapsed_s, start.cost_s);
                clock.end_at(17 + time_s + 1e-5);
                REQUIRE(s.record().status == TickStatus::done);
            }
            CHECK(s.safety().counters().late == 0);
            CHECK(s.counters().lost_s == 0);
            return force.norm();
        };
        const double wanted_N = force_at(1000, true);
        CHECK(wanted_N > 1e-4);
        // periods of 15 to 22 ms
        for (const bool says : {true, false}) CHECK(force_at(50, says, 0.12) == Approx(wanted_N).epsilon(0.01));
        for (const double rate_Hz : {10., 14.3, 20., 30., 39., 40., 50., 60., 100., 199., 500., 1000., 8000.})
            for (const bool says : {true, false}) {
                INFO(rate_Hz << " Hz, host gives elapsed time: " << says);
                CHECK(force_at(rate_Hz, says) == Approx(wanted_N).epsilon(0.01));
            }
    }
}

TEST_CASE("without elapsed time from the host the clock gives it from the second tick on", "[api]") {
    for (const double unknown : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        TickClock clock;
        CHECK(clock.start_at(unknown, 100).elapsed_s == 0);
        CHECK(clock.start_at(unknown, 100.02).elapsed_s == Approx(0.02));
        CHECK(clock.start_at(0.001, 100.03).elapsed_s == 0.001);
        TickClock copy = clock;
        CHECK(copy.start_at(unknown, 100.05).elapsed_s == Approx(0.02));
        CHECK(clock.start_at(unknown, 100.03).elapsed_s > 0);  // 0 would mean dt
    }

    const TemporaryFolder folder;
    Session session(model_file(folder, energy_model_example()));
    const double outside[3] = {0.05, 0.2, 0};
    double force[3];
    CHECK(tissue_tick(session.s, outside, -1, force) == TISSUE_OK);
    std::vector<char> state(tissue_state_size(session.s));
    CHECK(tissue_save(session.s, state.data(), state.size()) == TISSUE_OK);
    tissue_session* copy = nullptr;
    REQUIRE(tissue_copy(session.s, &copy) == TISSUE_OK);
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    CHECK(tissue_tick(copy, outside, -1, force) == TISSUE_OVERRUN);
    tissue_close(&copy);
    CHECK(tissue_restore(session.s, state.data(), state.size()) == TISSUE_OK);
    CHECK(tissue_tick(session.s, outside, -1, force) == TISSUE_OK);  // a restored state has no clock yet
}

TEST_CASE("the cost of ticks counts if the host's time follows the clock but not if both agree by chance", "[api]") {
    // Number of ticks whose cost counted. passed_s: clock time between ticks; says_s: elapsed time given by the host.
    const auto counted = [](int ticks, const auto& passed_s, const auto& says_s) {
        TickClock clock;
        Draw draw(2008);
        double now_s = 17;
        int count = 0;
        for (int k = 0; k < ticks; ++k) {
            const double passed = passed_s(k, draw);
            count += clock.start_at(says_s(k, passed), now_s += passed).cost_s > 0;
            clock.end_at(now_s + 4e-4);
        }
        return count;
    };
    const auto steady = [](int, Draw&) { return 1e-3; };
    const auto strays = [](int, Draw& draw) { return 1e-3 + draw(-4e-5, 4e-5); };
    const auto says_1_ms = [](int, double) { return 1e-3; };
    CHECK(counted(100, steady, [](int, double) { return std::nan(""); }) == 99);  // by the library's own clock
    CHECK(counted(100, steady, says_1_ms) == 50);
    // the host reads the clock some time before the tick
    CHECK(counted(1000, strays, [](int k, double passed) { return passed + (k % 2 ? 2e-5 : -2e-5); }) >= 950);
    // a replay with 1 ms, whose ticks take nearly 1 ms
    CHECK(counted(10000, strays, says_1_ms) < 100);
    for (const double off : {-0.04, -0.01, -0.002, 0.002, 0.01, 0.04}) CHECK(counted(10000, [&](int, Draw&) { return 1e-3 * (1 + off); }, says_1_ms) == 0);
    // ticks of growing length count soon
    CHECK(counted(10, [](int k, Draw&) { return 1e-3 * std::pow(1.5, k); }, [](int, double passed) { return passed; }) == 5);
    // a host interrupted between reading the clock and the tick
    CHECK(counted(1000, [](int k, Draw&) { return k == 500 ? 11e-3 : k == 501 ? 1e-5 : 1e-3; }, says_1_ms) == 950);
    CHECK(counted(1000, [](int k, Draw&) { return k < 500 ? 1e-3 : 3e-3; }, says_1_ms) < 460);
}

TEST_CASE("a larger struct of a newer caller is filled with zeros at its end and a smaller one is refused", "[api]") {
    const TissueModel tissue = energy_model_example();
    const TemporaryFolder folder;
    Session session(model_file(folder, tissue), {"force-max", "0.05"});
    double force[3];
    for (int k = 0; k < 700; ++k) tissue_tick(session.s, way(k, false).data(), 0, force);
    struct { tissue_limits now; long long later[2]; } newer;
    std::memset(&newer, 0x55, sizeof newer);
    CHECK(tissue_read_limits(session.s, &newer.now, sizeof newer) == TISSUE_OK);
    CHECK((newer.now.clamped > 0 && newer.later[0] == 0 && newer.later[1] == 0));
    tissue_contact contact;
    std::memset(&contact, 0x55, sizeof contact);
    for (const std::size_t size : {std::size_t{0}, sizeof(void*), sizeof newer.now - 1}) {
        CHECK(tissue_read_contact(session.s, &contact, size) == TISSUE_BAD_ARGUMENT);
        CHECK(tissue_read_limits(session.s, &newer.now, size) == TISSUE_BAD_ARGUMENT);
    }
    CHECK(contact.slipping == 0x55555555);
    CHECK(tissue_read_contact(session.s, &contact, sizeof contact) == TISSUE_OK);
    CHECK((contact.mesh == 0 && contact.grasped == 0));
}

TEST_CASE("kinetic friction set during a session can be reset to its default", "[api]") {
    const TemporaryFolder folder;
    Session session(model_file(folder, energy_model_example()));
    const auto set = [&](const char* name, const char* value) { return tissue_set(session.s, name, value); };
    CHECK(set("friction", "0.3") == TISSUE_OK);
    CHECK(set("friction-slip", "0.2") == TISSUE_OK);
    CHECK(set("friction", "0.1") == TISSUE_MISMATCH);  // below the kinetic one
    CHECK(set("friction-slip", "default") == TISSUE_OK);
    CHECK(set("friction", "0.1") == TISSUE_OK);
    CHECK(set("friction-slip", "0.2") == TISSUE_MISMATCH);
    CHECK(set("friction", "inf") == TISSUE_OK);
    CHECK(set("friction-slip", "0.2") == TISSUE_MISMATCH);
}

TEST_CASE("a late tick has status late and the session counts limited forces", "[api]") {
    const TemporaryFolder folder;
    Session session(model_file(folder, energy_model_example()), {"force-max", "0.05", "slew", "20"});
    double force[3];
    for (int k = 0; k < 700; ++k) CHECK(tissue_tick(session.s, way(k, false).data(), 0, force) == TISSUE_OK);
    tissue_limits limits;
    CHECK(tissue_read_limits(session.s, &limits, sizeof limits) == TISSUE_OK);
    CHECK((limits.clamped > 0 && limits.slewed > 0 && limits.late == 0 && limits.lost_s == 0));
    CHECK(tissue_tick(session.s, way(700, false).data(), 2, force) == TISSUE_LATE);
    CHECK(std::string(tissue_status_text(TISSUE_LATE)).find("the tick was so late") == 0);
    CHECK(std::hypot(force[0], force[1]) > 0);
    CHECK(tissue_tick(session.s, way(701, false).data(), 0, force) == TISSUE_OK);
    CHECK(tissue_read_limits(session.s, &limits, sizeof limits) == TISSUE_OK);
    CHECK(limits.late == 1);
    CHECK(limits.lost_s == Approx(1.5).margin(0.01));
    long long count = 0;
    CHECK(tissue_count(session.s, "clamped", &count) == TISSUE_OK);
    CHECK(count == limits.clamped);
    CHECK(tissue_count(session.s, "lost_ms", &count) == TISSUE_OK);
    CHECK(count == Approx(1e3 * limits.lost_s).margin(1));
    const double nowhere[3] = {std::nan(""), 0, 0};
    CHECK(tissue_tick(session.s, nowhere, 2, force) == TISSUE_FAULT);  // a fault takes precedence over a late tick
    // with a device that keeps its force only time is lost
    Session keeps(model_file(folder, energy_model_example()), {"hold", "inf"});
    for (int k = 0; k < 700; ++k) CHECK(tissue_tick(keeps.s, way(k, false).data(), 0, force) == TISSUE_OK);
    CHECK(tissue_tick(keeps.s, way(700, false).data(), 2, force) == TISSUE_OVERRUN);
    CHECK(std::string(tissue_status_text(TISSUE_OVERRUN)).find("time was lost") == 0);
    CHECK(std::hypot(force[0], force[1]) > 0);
}

TEST_CASE("force limited by the bound on energy is counted and recovers", "[api]") {
    const TemporaryFolder folder;
    Session session(model_file(folder, energy_model_example()));
    const auto press = [&](int ticks, double elapsed_s) {
        const double at[3] = {0.05, 0.095, 0};
        double force[3];
        for (int k = 0; k < ticks; ++k) CHECK(tissue_tick(session.s, at, elapsed_s, force) == (elapsed_s > 0.025 ? TISSUE_LATE : TISSUE_OK));
        return std::hypot(force[0], force[1]);
    };
    double outside[3] = {0.05, 0.102, 0}, force[3];
    for (int k = 0; k < 7; ++k, outside[1] -= 0.001) CHECK(tissue_tick(session.s, outside, 0, force) == TISSUE_OK);
    const auto capped = [&] {
        tissue_limits limits;
        long long count = -1;
        CHECK(tissue_read_limits(session.s, &limits, sizeof limits) == TISSUE_OK);
        CHECK(tissue_count(session.s, "capped", &count) == TISSUE_OK);
        CHECK(count == limits.capped);
        return count;
    };
    const double whole_N = press(8000, 0);
    REQUIRE(whole_N > 0.3);
    CHECK(capped() == 0);
    press(40, 0.04);  // too late for hold: the most energy that the hand may have got is counted each time
    const long long late = capped();
    CHECK(late > 0);
    CHECK(press(20, 0) < 0.9 * whole_N);
    CHECK(capped() > late);
    CHECK(press(20000, 0) == Approx(whole_N).epsilon(1e-3));
    const long long recovered = capped();
    press(1000, 0);
    CHECK(capped() == recovered);
}

TEST_CASE("the tool is selected when a session is opened and cannot be changed later", "[api][solid]") {
    const TemporaryFolder folder;
    const std::string file = model_file(folder, several_discs());
    Session session(file, {"tool", "ball:0.005"});
    CHECK(tissue_tool_shape(session.s) == std::string("ball"));
    CHECK(tissue_tool_radius(session.s) == 0.005);
    CHECK(tissue_set(session.s, "tool", "disc") == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_tool_shape(nullptr) == std::string());
    tissue_session* none = nullptr;
    const char* const large[] = {"tool", "ball:0.05", nullptr};
    CHECK(tissue_open(file.c_str(), large, &none) == TISSUE_MISMATCH);
    CHECK(std::string(tissue_error()).find("discs from 4 to 10 mm") != std::string::npos);
    const char* const unknown[] = {"tool", "needle", nullptr};
    CHECK(tissue_open(file.c_str(), unknown, &none) == TISSUE_BAD_ARGUMENT);
    CHECK(none == nullptr);
}

TEST_CASE("two tools in C have the forces of the library and calls refer to the selected tool", "[api][solid][two]") {
    const TemporaryFolder folder;
    const TissueModel tissue = several_discs();
    const std::string file = model_file(folder, tissue);
    Session session(file, {"tools", "2"});
    REQUIRE(tissue_tool_count(session.s) == 2);
    CHECK(tissue_tool_count(nullptr) == 0);
    REQUIRE(tissue_use_tool(session.s, 1) == TISSUE_OK);
    CHECK(tissue_set(session.s, "friction", "0.25") == TISSUE_OK);
    CHECK(tissue_set(session.s, "force-max", "0.04") == TISSUE_OK);  // until the first tick
    CHECK(tissue_set(session.s, "hold", "0.2") == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_set(session.s, "slew", "-1") == TISSUE_MISMATCH);
    HapticOptions options = interface_options();
    options.tools = 2;
    const HapticModel model(tissue, options);
    Simulation simulation(model);
    HapticOptions second = simulation.options(1);
    second.friction.stick = 0.25;
    second.safety.force_max_N = 0.04;
    simulation.change(second, 1);
    const Eigen::Vector3d high = model.high_m, low = model.low_m, from(low.x() + 0.35 * (high - low).x(), (low + high).y() / 2, high.z() + 0.001), along(0.3 * (high - low).x(), 0, 0);
    double position_m[6], force_N[6];
    tissue_status status[2];
    for (int k = 0; k < 400; ++k) {
        const Eigen::Vector3d down(0, 0, -1e-5 * k), at[2] = {from + down, from + along + 0.5 * down + Eigen::Vector3d(0, 1e-5 * k, 0)};
        DeviceSample samples[2];
        Eigen::Vector3d forces[2];
        for (int t = 0; t < 2; ++t) {
            samples[t].position_m = at[t];
            Eigen::Map<Eigen::Vector3d>(position_m + 3 * t) = at[t];
        }
        simulation.tick(samples, forces, 1e-3);
        REQUIRE(tissue_tick_tools(session.s, 2, position_m, nullptr, 1e-3, force_N, status) == TISSUE_OK);
        for (int t = 0; t < 2; ++t) REQUIRE(Eigen::Map<const Eigen::Vector3d>(force_N + 3 * t) == forces[t]);
    }
    for (int t = 0; t < 2; ++t) {
        INFO(t);
        REQUIRE(tissue_use_tool(session.s, t) == TISSUE_OK);
        tissue_contact contact;
        REQUIRE(tissue_read_contact(session.s, &contact, sizeof contact) == TISSUE_OK);
        CHECK(contact.mesh == 0);
        CHECK(contact.facet == simulation.record(t).facet);
        CHECK(-Eigen::Map<const Eigen::Vector3d>(contact.force_N) == simulation.record(t).coupling_N);
        double given_J = 0;
        REQUIRE(tissue_energy(session.s, "given", &given_J) == TISSUE_OK);
        CHECK(given_J == simulation.safety(t).counters().energy_given_J);
        CHECK(given_J < 0);
    }
    CHECK(simulation.friction(1).dissipated_J() > 0);
    CHECK(simulation.safety(0).counters().force_max_N > 0.06);
    CHECK(simulation.safety(1).counters().force_max_N == Approx(0.04).epsilon(1e-6));
    CHECK(tissue_set(session.s, "force-max", "0.2") == TISSUE_BAD_ARGUMENT);
    CHECK(std::string(tissue_error()).find("'force-max' may change only until the first tick") != std::string::npos);
    // a fault of the second tool does not stop the first
    const double first_N = force_N[2];
    position_m[3] = std::nan("");
    CHECK(tissue_tick_tools(session.s, 2, position_m, nullptr, 1e-3, force_N, status) == TISSUE_FAULT);
    CHECK(status[0] == TISSUE_OK);
    CHECK(status[1] == TISSUE_FAULT);
    CHECK(force_N[2] == Approx(first_N).epsilon(0.05));
    CHECK(force_N[5] == 0);
    const double stale_s[2] = {0, 1};
    position_m[3] = from.x();
    CHECK(tissue_tick_tools(session.s, 2, position_m, stale_s, 1e-3, force_N, nullptr) == TISSUE_FAULT);
    // one array for positions and forces
    Session same(file, {"tools", "2"}), apart(file, {"tools", "2"});
    for (int k = 0; k < 200; ++k) {
        double both[6] = {from.x(), from.y(), from.z() - 2e-5 * k, from.x() + along.x(), from.y(), from.z() - 1e-5 * k}, out[6];
        tissue_tick_tools(apart.s, 2, both, nullptr, 1e-3, out, nullptr);
        tissue_tick_tools(same.s, 2, both, nullptr, 1e-3, both, nullptr);
        REQUIRE(std::equal(both, both + 6, out));
        if (k == 199) CHECK(out[2] > 0);
    }
    // A copy has the same selected tool. A wrong number of tools is refused with zero forces.
    tissue_session* copy = nullptr;
    REQUIRE(tissue_copy(session.s, &copy) == TISSUE_OK);
    long long stale = 0;
    CHECK(tissue_count(copy, "stale", &stale) == TISSUE_OK);
    CHECK(stale == 1);
    tissue_close(&copy);
    force_N[0] = force_N[2] = 1;
    CHECK(tissue_tick(session.s, position_m, 0, force_N) == TISSUE_BAD_ARGUMENT);
    CHECK((force_N[0] == 0 && force_N[2] == 0));
    for (int tools : {-1, 0, 1, 3}) {
        double nine[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
        CHECK(tissue_tick_tools(session.s, tools, nine, nullptr, 0, nine, nullptr) == TISSUE_BAD_ARGUMENT);
        CHECK(nine[0] == (tools > 0 ? 0 : 1));
    }
    CHECK(tissue_use_tool(session.s, 2) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_use_tool(session.s, -1) == TISSUE_BAD_ARGUMENT);
    CHECK(tissue_use_tool(nullptr, 0) == TISSUE_BAD_ARGUMENT);
    Session one(file);
    CHECK(tissue_tick_tools(one.s, 2, position_m, nullptr, 0, force_N, nullptr) == TISSUE_BAD_ARGUMENT);
}
