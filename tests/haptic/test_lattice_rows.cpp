// Rows of an embedded lattice's nodes in the arrays of the tick.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "../allocations.h"
#include "../mesh/dome.h"
#include "../refusal.h"
#include "error.h"
#include "haptic/lattice_rows.h"
#include "haptic/realtime_mesh.h"
#include "mesh/embedded_lattice.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

constexpr double spacing_m = 0.004;

/// A mesh of one node of a solid and of lattice nodes at these places.
SpringMesh at_places(const std::vector<std::array<int, 3>>& places) {
    SpringMesh mesh;
    mesh.embedding.spacing_m = spacing_m;
    mesh.embedding.corner = Cells::Zero(1, 8);
    mesh.nodes = NodeField::Zero(1 + static_cast<Eigen::Index>(places.size()), 3);
    for (std::size_t n = 0; n < places.size(); ++n)
        for (std::size_t d = 0; d < 3; ++d) mesh.nodes(static_cast<Eigen::Index>(n) + 1, static_cast<Eigen::Index>(d)) = 0.1 + spacing_m * places[n][d];
    return mesh;
}

}  // namespace

TEST_CASE("rows of an embedded lattice are distinct with constant neighbour offsets per layer and gather inverts scatter", "[embedded][solid]") {
    const SpringMesh mesh = embedded_lattice(dome(8), spacing_m);
    const LatticeRows rows(mesh);
    const int own = mesh.embedding.node_count(), N = mesh.node_count();
    REQUIRE(!rows.by_node());
    CHECK(rows.count() <= 2 * (N - own));
    std::set<int> taken;
    for (int n = 0; n < N; ++n) {
        if (n < own) {
            CHECK(rows.of(n) == -1);
            continue;
        }
        CHECK((rows.of(n) >= 0 && rows.of(n) < rows.count()));
        taken.insert(rows.of(n));
    }
    CHECK(static_cast<int>(taken.size()) == N - own);

    std::map<std::array<long, 4>, std::set<int>> apart;  // by step of a spring and layer of its lower end
    for (Eigen::Index s = 0; s < mesh.springs.rows(); ++s) {
        const int i = mesh.springs.row(s).minCoeff(), j = mesh.springs.row(s).maxCoeff();
        const Eigen::RowVector3d step = (mesh.nodes.row(j) - mesh.nodes.row(i)) / spacing_m;
        const long layer = std::lround(step[2]) == 0 ? 0 : std::lround(mesh.nodes(i, 2) / spacing_m);
        apart[{std::lround(step[0]), std::lround(step[1]), std::lround(step[2]), layer}].insert(rows.of(j) - rows.of(i));
    }
    for (const auto& [step, offsets] : apart) {
        INFO(step[0] << " " << step[1] << " " << step[2] << " layer " << step[3]);
        CHECK(offsets.size() == 1);
    }
    const std::set<int> along_x = apart.at({1, 0, 0, 0});
    CHECK(along_x == std::set<int>{1});

    NodeColumns u = NodeColumns::Random(N, 3), by_row = NodeColumns::Zero(rows.count(), 3), back = NodeColumns::Ones(N, 3);
    {
        const Allocations none;
        rows.scatter(u, by_row);
        rows.gather(by_row, back);
        CHECK(Allocations::count() == 0);
    }
    for (int n = own; n < N; ++n) CHECK(by_row.row(rows.of(n)) == u.row(n));
    for (int row = 0; row < rows.count(); ++row)
        if (taken.count(row) == 0) CHECK(by_row.row(row).isZero(0));
    u.topRows(own).setZero();
    CHECK(back == u);
}

TEST_CASE("springs of an embedded lattice form long bands with few empty slots and mostly equal springs", "[embedded][solid]") {
    const SpringMesh mesh = embedded_lattice(dome(8), spacing_m);
    Eigen::VectorXd mass = Eigen::VectorXd::Ones(mesh.node_count());
    mass.head(mesh.embedding.node_count()).setZero();
    const RealtimeMesh springs(mesh, "geometric", mass);
    int alike = 0;
    for (const RealtimeMesh::Band& band : springs.bands()) alike += band.alike ? band.count : 0;
    CHECK(springs.slot_count() >= 60 * static_cast<int>(springs.bands().size()));
    CHECK(springs.slot_count() <= 1.6 * springs.spring_count());
    CHECK(alike >= 0.98 * springs.slot_count());
}

TEST_CASE("a sparse or very distant lattice keeps its node order and two nodes at one place are refused", "[embedded][solid]") {
    std::vector<std::array<int, 3>> stick;
    for (int n = 0; n < 30; ++n) {
        stick.push_back({n, n, 0});
        stick.push_back({n, n, 1});
    }
    const SpringMesh diagonal = at_places(stick);
    const LatticeRows by_node(diagonal);
    CHECK(by_node.by_node());
    CHECK(by_node.count() == diagonal.node_count());
    CHECK(by_node.of(7) == 7);

    // Nodes so far apart that row numbers are not exact in floating point, although there are few rows. Such rows would
    // be out of range.
    SpringMesh far = at_places(std::vector<std::array<int, 3>>(710, {0, 0, 0}));
    far.embedding.spacing_m = std::ldexp(1.0, -44);
    far.nodes.row(1) << 512, 8773495498113277, 0;
    for (int k = 0; k < 8; ++k) far.nodes.row(2 + k) << k % 2, k / 2 % 2, 1 + k / 4;
    far.nodes.row(10) << 999, 0, 3;
    for (int n = 11; n <= 710; ++n) far.nodes.row(n) << 0, 0, n - 7;
    far.nodes *= far.embedding.spacing_m;
    CHECK(LatticeRows(far).by_node());

    CHECK(!LatticeRows(at_places({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}})).by_node());
    CHECK_THAT(refusal<MismatchError>([] { LatticeRows(at_places({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}})); }), Contains("node 3"));
}
