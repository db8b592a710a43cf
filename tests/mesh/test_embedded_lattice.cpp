#include "mesh/solid_block.h"
#include "mesh/embedded_lattice.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <map>

#include "../example.h"
#include "dome.h"
#include "error.h"
#include "mesh/cells.h"
#include "springs/cell_volumes.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

constexpr double mm = 1e-3;

/// The dome rotated, so that its bed and its surface cut cubes at all angles.
Shape turned_dome() {
    Shape shape = dome(8);
    const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())).toRotationMatrix();
    shape.nodes = (shape.nodes * turn.transpose()).eval();
    return shape;
}

double volume_of(const Shape& shape) {
    double sum = 0;
    for (Eigen::Index t = 0; t < shape.simplices.rows(); ++t) {
        const auto at = [&](int k) { return Eigen::Vector3d(shape.nodes.row(shape.simplices(t, k))); };
        sum += (at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) / 6;
    }
    return sum;
}

}  // namespace

TEST_CASE("a block fills its cubes and a spring's measure is the sum of its shares of adjacent cubes", "[embedded]") {
    const Shape block = solid_block({{4, 3, 2}, {0.04, 0.03, 0.02}});
    const SpringMesh mesh = embedded_lattice(block, 0.01);
    const auto K = block.nodes.rows();
    REQUIRE(mesh.embedding.node_count() == K);
    REQUIRE(mesh.node_count() == 2 * K);
    CHECK((mesh.nodes.bottomRows(K) - block.nodes).cwiseAbs().maxCoeff() < 1e-15);
    CHECK((mesh.embedding.fraction.array() - 1).abs().maxCoeff() < 1e-9);
    CHECK((mesh.embedding.centroid.array() - 0.5).abs().maxCoeff() < 1e-9);
    std::map<std::pair<int, int>, double> measure;
    Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.node_count());
    for (Eigen::Index c = 0; c < mesh.embedding.cubes.rows(); ++c)
        for (int i = 0; i < 8; ++i) {
            mass[mesh.embedding.cubes(c, i)] += 1e-6 / 8;
            for (int j = i + 1; j < 8; ++j) {
                const bool face = __builtin_popcount(static_cast<unsigned>(i ^ j)) == 2;
                measure[std::minmax(mesh.embedding.cubes(c, i), mesh.embedding.cubes(c, j))] += (face ? 1.0 / 6 : 1.0 / 4) * 1e-6;
            }
        }
    REQUIRE(static_cast<std::size_t>(mesh.spring_count()) == measure.size());
    for (int s = 0; s < mesh.spring_count(); ++s) CHECK(mesh.incident_measure[s] == Approx(measure.at(std::minmax(mesh.springs(s, 0), mesh.springs(s, 1)))).epsilon(1e-9));
    CHECK((mesh.node_measure - mass).cwiseAbs().maxCoeff() < 1e-9 * mass.maxCoeff());
}

TEST_CASE("the cubes of an embedded lattice contain the solid's volume to 0.3 per cent", "[embedded]") {
    for (const Shape& shape : {dome(8), turned_dome()})
        for (const double h : {11 * mm, 7.3 * mm}) {
            const SpringMesh mesh = embedded_lattice(shape, h);
            const double in_cubes = h * h * h * mesh.embedding.fraction.sum(), volume = volume_of(shape);
            INFO(h);
            CHECK(in_cubes == Approx(volume).epsilon(3e-3));
            CHECK(in_cubes < 1.001 * volume);  // cubes with very little tissue are dropped
            CHECK(mesh.embedding.fraction.minCoeff() > 0.02);
            CHECK(mesh.embedding.fraction.maxCoeff() < 1 + 1e-9);
            CHECK(mesh.node_measure.sum() == Approx(in_cubes).epsilon(5e-3));  // with the lower limit of node_measure
            CHECK(mesh.node_measure.head(mesh.embedding.node_count()).isZero(0));
        }
}

TEST_CASE("a cut cube has spring measures by its tissue's moments and its volume gradient at the centroid", "[embedded]") {
    const double h = 0.01, V = h * h * h;
    const SpringMesh mesh = embedded_lattice(solid_block(Lattice{{4, 4, 1}, {0.04, 0.04, 0.015}}), h);  // the upper cubes are half full
    const int K = mesh.embedding.node_count();
    REQUIRE(mesh.embedding.cubes.rows() == 32);
    const auto node = [&](int x, int y, int z) { return K + (z * 5 + y) * 5 + x; };
    const auto measure = [&](int i, int j) {
        for (int s = 0; s < mesh.spring_count(); ++s)
            if (std::minmax(mesh.springs(s, 0), mesh.springs(s, 1)) == std::minmax(i, j)) return mesh.incident_measure[s] / V;
        return 0.0;
    };
    // hat moments of the half: 3/32 at each lower corner, 1/32 at each upper one
    CHECK(measure(node(1, 2, 2), node(2, 2, 2)) == Approx(2 * 4 * 2 / 32.0 / 4));           // an edge of two cubes, on top
    CHECK(measure(node(1, 2, 1), node(2, 2, 1)) == Approx((2 * 4 * 6 / 32.0 + 2) / 4));     // between half and whole ones
    CHECK(measure(node(1, 2, 1), node(1, 2, 2)) == Approx(4 * 4 * 4 / 32.0 / 4));           // vertical, of four
    CHECK(measure(node(1, 1, 2), node(2, 2, 2)) == Approx(2 * 4 / 32.0 / 6));               // a face on top
    CHECK(measure(node(1, 1, 1), node(2, 2, 2)) == Approx(0.5 / 4));                        // a body diagonal
    CHECK(mesh.node_measure[node(2, 2, 2)] == Approx(4 * 0.5 / 8 * V));
    CHECK(mesh.node_measure[node(2, 2, 1)] == Approx(4 * 1.5 / 8 * V));
    const Eigen::Index cut = 31;
    CHECK(mesh.embedding.fraction[cut] == Approx(0.5));
    CHECK((mesh.embedding.centroid.row(cut) - Eigen::RowVector3d(0.5, 0.5, 0.25)).norm() < 1e-9);
    const CellVolumes volumes(mesh);
    CHECK(volumes.volumes()[cut] == Approx(V / 2));
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  // of x z, which is trilinear
    for (int k = 0; k < 8; ++k) {
        const Eigen::RowVector3d at = mesh.nodes.row(mesh.embedding.cubes(cut, k));
        gradient += at.x() * at.z() * volumes.gradient(static_cast<int>(cut)).col(k);
    }
    CHECK((gradient - Eigen::Vector3d(0.0125, 0, 0.035)).norm() < 1e-12);
}

TEST_CASE("a fixed plane is a lattice plane of the embedded lattice", "[embedded]") {
    Shape shape = dome(6);
    shape.nodes.col(2).array() += 3.3 * mm;
    const SpringMesh mesh = embedded_lattice(shape, 9 * mm);
    const Eigen::VectorXd z = mesh.nodes.col(2).tail(mesh.node_count() - mesh.embedding.node_count());
    CHECK(z.minCoeff() == Approx(3.3 * mm).margin(1e-12));
    CHECK(mesh.springs.minCoeff() >= mesh.embedding.node_count());
    CHECK(mesh.fixed == edge_mesh(shape).fixed);
}

TEST_CASE("the lattice of a solid without a fixed surface is centred on its bounding box", "[embedded]") {
    Shape shape = dome(6);
    shape.fixed_facets.clear();
    const SpringMesh mesh = embedded_lattice(shape, 9 * mm);
    const auto middle = [](const NodeField& nodes) { return Eigen::RowVectorXd((nodes.colwise().minCoeff() + nodes.colwise().maxCoeff()) / 2); };
    CHECK((middle(mesh.nodes.bottomRows(mesh.node_count() - mesh.embedding.node_count())) - middle(shape.nodes)).norm() < 1e-12);
    CHECK(mesh.fixed.empty());
}

TEST_CASE("interpolation from the lattice to the solid's nodes is exact for linear fields", "[embedded]") {
    const SpringMesh mesh = embedded_lattice(turned_dome(), 9 * mm);
    const int K = mesh.embedding.node_count();
    const Eigen::Matrix3d strain = (Eigen::Matrix3d() << 1, 0.3, -2, 0.5, -1, 0.1, 0.2, 0.4, 0.7).finished();
    NodeField u = mesh.nodes * strain;
    u.topRows(K).setConstant(7);
    mesh.embedding.interpolate(u);
    CHECK((u - mesh.nodes * strain).cwiseAbs().maxCoeff() < 1e-14);
}

TEST_CASE("an embedded lattice with zero spacing or too many cubes is refused", "[embedded]") {
    CHECK_THROWS_WITH(embedded_lattice(dome(6), 0), Contains("spacing > 0"));
    CHECK_THROWS_WITH(embedded_lattice(dome(6), 1e-5), Contains("cubes"));
}
