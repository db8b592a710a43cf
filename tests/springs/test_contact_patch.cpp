#include "springs/contact_patch.h"

#include <catch2/catch.hpp>
#include <algorithm>
#include <cmath>
#include <functional>

#include "../allocations.h"
#include "../example.h"
#include "../mesh/disc.h"
#include "../tolerances.h"

using namespace tissue;

namespace {

const SpringMesh& block() {
    static const SpringMesh mesh = make_lattice("grid8", 10, 10, 0.1, 0.1);
    return mesh;
}

/// A disc whose outline has nodes 17 to 34 mm apart.
SpringMesh uneven() {
    Shape shape = disc(12);
    for (int i = 0; i < 12; ++i) {
        const double angle = 2 * std::acos(-1.0) * (i + 0.2 * std::sin(2.0 * i)) / 12;
        shape.nodes.row(i) << 0.05 * std::cos(angle), 0.05 * std::sin(angle);
    }
    return edge_mesh(shape);
}

void set_to(Eigen::Vector2d (&u)[ContactPatch::size], const std::function<Eigen::Vector2d(int)>& value) {
    for (int i = 0; i < ContactPatch::size; ++i) u[i] = value(i);
}

}  // namespace

TEST_CASE("along the whole surface a patch's weights are not negative and sum to 1; its slopes sum to 0") {
    for (const SpringMesh& mesh : {block(), uneven()}) {
        const ContactSurface surface(mesh);
        for (double part = 0; part <= 1; part += 1.0 / 512) {
            const ContactPatch patch = surface.at(part * surface.outline().length());
            double sum = 0, slopes = 0;
            for (int i = 0; i < ContactPatch::size; ++i) {
                CHECK(patch.weight[i] >= 0);
                sum += patch.weight[i];
                slopes += patch.slope[i];
            }
            CHECK(sum == Approx(1).epsilon(tolerance::rounding));
            CHECK(std::abs(slopes) <= tolerance::rounding);
        }
    }
}

TEST_CASE("the weights of a patch reproduce the arc length of its place for any spacing of the nodes") {
    for (const SpringMesh& mesh : {block(), uneven()}) {
        const ContactSurface surface(mesh);
        const std::vector<int>& nodes = surface.outline().nodes();
        const std::vector<double>& arcs = surface.outline().arcs();
        for (double arc = arcs[1]; arc <= arcs[arcs.size() - 2]; arc += 0.00137) {
            const ContactPatch patch = surface.at(arc);
            double at = 0;
            for (int i = 0; i < ContactPatch::size; ++i)
                at += patch.weight[i] * arcs[static_cast<std::size_t>(std::find(nodes.begin(), nodes.end(), patch.node[i]) - nodes.begin())];
            CHECK(at == Approx(arc).epsilon(tolerance::rounding));
        }
    }
}

TEST_CASE("on a flat side a patch reproduces a linear displacement and its slope") {
    const ContactSurface surface(block());
    const Eigen::Vector2d shift(0.002, -0.001), per_m(0.3, -0.2);
    for (double arc : {0.03, 0.0412, 0.05, 0.1337, 0.147, 0.243}) {
        const ContactPatch patch = surface.at(arc);
        const Eigen::Vector2d place = surface.outline().position(arc);
        Eigen::Vector2d u = Eigen::Vector2d::Zero(), slope = u;
        for (int i = 0; i < ContactPatch::size; ++i) {
            const Eigen::Vector2d X = block().nodes.row(patch.node[i]);
            u += patch.weight[i] * (shift + per_m * X.sum());
            slope += patch.slope[i] * (shift + per_m * X.sum());
        }
        CHECK((u - shift - per_m * place.sum()).norm() <= tolerance::rounding);
        CHECK((slope - 0.01 * per_m * patch.tangent.sum()).norm() <= tolerance::rounding);  // nodes 10 mm apart
        CHECK((patch.normal - surface.outline().inward_normal(arc)).norm() <= tolerance::rounding);
        CHECK(patch.corner <= tolerance::rounding);
    }
}

TEST_CASE("around a corner a patch's weights and slopes and normal change continuously") {
    const ContactSurface surface(block());
    const ContactPatch at_corner = surface.at(0.1);
    CHECK((at_corner.normal - Eigen::Vector2d(-1, -1).normalized()).norm() <= tolerance::rounding);
    CHECK(at_corner.corner == Approx(1).epsilon(tolerance::rounding));
    CHECK((surface.at(0.09).normal - Eigen::Vector2d(-1, 0)).norm() <= tolerance::rounding);
    CHECK((surface.at(0.11).normal - Eigen::Vector2d(0, -1)).norm() <= tolerance::rounding);
    const double step = 1e-5;
    for (double arc = 0.085; arc < 0.115; arc += step) {
        const ContactPatch before = surface.at(arc), after = surface.at(arc + step);
        Eigen::VectorXd w = Eigen::VectorXd::Zero(block().node_count()), slope = w;
        for (int i = 0; i < ContactPatch::size; ++i) {
            w[before.node[i]] -= before.weight[i];
            w[after.node[i]] += after.weight[i];
            slope[before.node[i]] -= before.slope[i];
            slope[after.node[i]] += after.slope[i];
        }
        CHECK(w.lpNorm<1>() < 2 * step / 0.01);
        CHECK(slope.lpNorm<1>() < 8 * step / 0.01);
        CHECK((after.normal - before.normal).norm() < 3 * step / 0.01);
    }
}

TEST_CASE("a patch at the fixed edge repeats the end node; a place beyond the surface is clamped to its end") {
    const ContactSurface surface(block());
    const ContactPatch first = surface.at(0);
    CHECK(first.node[0] == first.node[1]);
    CHECK(block().nodes(first.node[0], 1) == 0);
    CHECK(surface.at(-0.5).place == first.place);
    CHECK(surface.at(5).place == surface.at(surface.outline().length()).place);
    CHECK(surface.at(5).edge == Approx(1));
}

TEST_CASE("contact forces of a patch are derivatives of its energy and its tangent is that of the forces") {
    const ContactSurface surface(block());
    for (double arc : {0.034, 0.1, 0.1069}) {
        const PatchSpring contact(surface.at(arc), {3.1, 1.7, 0.6, 0.4});
        const Eigen::Vector2d d(0.004, -0.003);
        Eigen::Vector2d u[ContactPatch::size];
        set_to(u, [](int i) { return Eigen::Vector2d(0.001 * std::sin(3.0 * i), 0.002 * std::cos(2.0 * i)); });
        const PatchSpring::Load load = contact.load(d, u);
        const double h = 1e-5;
        for (int axis : {0, 1}) {
            const Eigen::Vector2d e = h * Eigen::Vector2d::Unit(axis);
            CHECK((contact.load(d + e, u).energy_J - contact.load(d - e, u).energy_J) / (2 * h) ==
                  Approx(load.tool_force_N[axis]).epsilon(tolerance::difference));
            for (int i = 0; i < ContactPatch::size; ++i) {
                Eigen::Vector2d ahead[ContactPatch::size], behind[ContactPatch::size];
                set_to(ahead, [&](int k) { return k == i ? Eigen::Vector2d(u[k] + e) : u[k]; });
                set_to(behind, [&](int k) { return k == i ? Eigen::Vector2d(u[k] - e) : u[k]; });
                const PatchSpring::Load a = contact.load(d, ahead), b = contact.load(d, behind);
                CHECK((a.energy_J - b.energy_J) / (2 * h) == Approx(load.node_N[i][axis]).epsilon(tolerance::difference).margin(1e-12));
                for (int j = 0; j < ContactPatch::size; ++j)
                    CHECK(((a.node_N[j] - b.node_N[j]) / (2 * h) - contact.tangent(j, i).col(axis)).norm() <= tolerance::difference);
            }
        }
    }
}

TEST_CASE("a tool that moves with the tissue has no force; forces on tool and nodes sum to zero") {
    const ContactSurface surface(block());
    const PatchSpring contact(surface.at(0.0931), {3.1, 1.7, 0.6, 0.4});
    const Eigen::Vector2d d(0.004, -0.003);
    Eigen::Vector2d u[ContactPatch::size];
    set_to(u, [&](int) { return d; });
    CHECK(contact.load(d, u).tool_force_N.norm() <= tolerance::rounding);
    CHECK(contact.load(d, u).energy_J <= tolerance::rounding * d.squaredNorm());
    set_to(u, [](int i) { return Eigen::Vector2d(0.001 * i, -0.002 * i * i); });
    const PatchSpring::Load load = contact.load(d, u);
    Eigen::Vector2d sum = load.tool_force_N;
    for (const Eigen::Vector2d& f : load.node_N) sum += f;
    CHECK(sum.norm() <= tolerance::rounding * load.tool_force_N.norm());
}

TEST_CASE("finding a patch and its load allocates nothing") {
    const ContactSurface surface(uneven());
    ContactParameters contact_parameters;
    Eigen::Vector2d u[ContactPatch::size];
    set_to(u, [](int i) { return Eigen::Vector2d(0.001 * i, 0); });
    double energy = 0;
    {
        const Allocations none;
        const ContactPatch patch = surface.at(0.0371);
        energy = PatchSpring(patch, contact_parameters.at(patch)).load({0.001, 0}, u).energy_J;
    }
    CHECK(Allocations::count() == 0);
    CHECK(energy > 0);
}
