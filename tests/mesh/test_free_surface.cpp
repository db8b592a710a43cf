#include "mesh/free_surface.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "embedded_block.h"
#include "mesh/facet.h"
#include "mesh/mesh_fault.h"
#include "mesh/topology.h"
#include "../tolerances.h"

using namespace tissue;

namespace {

SpringMesh block() { return embedded_block(Lattice{{4, 3, 2}, {0.04, 0.03, 0.02}}); }

}  // namespace

TEST_CASE("the free surface of a block excludes its bottom and gives nearest points and inward normals", "[solid]") {
    const SpringMesh mesh = block();
    const FreeSurface surface(mesh);
    CHECK(surface.fixed_facets_of_surface().rows() == 2 * 4 * 3);
    CHECK(surface.facets().rows() + surface.fixed_facets_of_surface().rows() == mesh.facets.rows());
    CHECK(surface.spacing_m() == Approx(0.01).epsilon(tolerance::rounding));
    CHECK(compared_nodes(mesh) == surface.nodes());
    CHECK(std::count(surface.nodes().begin(), surface.nodes().end(), node_at(mesh, Eigen::Vector3d(0.02, 0.01, 0.01))) == 0);
    const FreeSurface::Place top = surface.nearest(Eigen::Vector3d(0.013, 0.017, 0.025));
    CHECK((top.point_m - Eigen::Vector3d(0.013, 0.017, 0.02)).norm() < 1e-12);
    CHECK((top.inward - Eigen::Vector3d(0, 0, -1)).norm() < 1e-12);
    CHECK(top.distance_m == Approx(0.005));
    CHECK((surface.nearest(Eigen::Vector3d(0.001, 0.015, 0.011)).inward - Eigen::Vector3d(1, 0, 0)).norm() < 1e-12);
    CHECK(surface.to_crease_m(Eigen::Vector3d(0.02, 0.015, 0.02)) == Approx(std::hypot(0.0, 0.015)));
    const Eigen::Vector3d in(0, 0, -1);
    CHECK(surface.faces(node_at(mesh, Eigen::Vector3d(0.01, 0.01, 0.02)), in));
    CHECK_FALSE(surface.faces(node_at(mesh, Eigen::Vector3d(0, 0.01, 0.01)), in));
}

TEST_CASE("nearest_on_facet gives points on a triangle's face or side or corner", "[solid]") {
    NodeField nodes(3, 3);
    nodes << 0, 0, 0, 1, 0, 0, 0, 1, 0;
    Cells facet(1, 3);
    facet << 0, 1, 2;
    CHECK(nearest_on_facet(nodes, facet, 0, Eigen::Vector3d(0.2, 0.3, 0.7)).distance_m == Approx(0.7));
    const FacetPoint side = nearest_on_facet(nodes, facet, 0, Eigen::Vector3d(0.4, -2, 0)), corner = nearest_on_facet(nodes, facet, 0, Eigen::Vector3d(3, -1, 0));
    CHECK((side.weight - Eigen::Vector3d(0.6, 0.4, 0)).norm() < 1e-12);
    CHECK((corner.weight - Eigen::Vector3d(0, 1, 0)).norm() < 1e-12);
    CHECK(corner.distance_m == Approx(std::sqrt(5.0)));
    CHECK(facet_measure(nodes, facet, 0) == Approx(0.5));
}

TEST_CASE("mesh_fault names the wrong part of a solid's mesh", "[solid]") {
    const auto part = [](const SpringMesh& mesh) { return mesh_fault(mesh).value_or(MeshFault{"none", ""}).part; };
    SpringMesh mesh = block();
    CHECK(part(mesh) == "none");
    std::swap(mesh.simplices(3, 0), mesh.simplices(3, 1));
    CHECK(part(mesh) == "tetrahedra");
    mesh = block();
    mesh.simplices.row(3) = mesh.simplices.row(2).eval();
    CHECK(part(mesh) == "tetrahedra");
    mesh = block();
    std::swap(mesh.facets(5, 0), mesh.facets(5, 1));
    CHECK(part(mesh) == "facets");
    mesh = block();
    mesh.fixed.resize(2);
    CHECK(part(mesh) == "fixed");
}

namespace {

/// A facet of the mesh and weights at a point of the free surface.
std::pair<int, Eigen::Vector3d> place_at(const SpringMesh& mesh, const FreeSurface& surface, const Point& point_m) {
    const Eigen::Index free = surface.nearest(point_m).facet;
    const auto facet = std::find(surface.free_of().begin(), surface.free_of().end(), free) - surface.free_of().begin();
    return {static_cast<int>(facet), nearest_on_facet(mesh.nodes, mesh.facets, facet, point_m).weight};
}

Point point_of(const SpringMesh& mesh, const FreeSurface::Walk& walk) {
    Point x = Point::Zero(mesh.dimension());
    for (Eigen::Index k = 0; k < mesh.facets.cols(); ++k) x += walk.weight[k] * mesh.nodes.row(mesh.facets(walk.facet, k)).transpose();
    return x;
}

}  // namespace

TEST_CASE("a walk on a flat face is straight and as long as its tangential vector", "[solid]") {
    const SpringMesh mesh = block();
    const FreeSurface surface(mesh);
    for (const Eigen::Vector3d& way : {Eigen::Vector3d(0.017, 0.011, 0), {-0.01, 0.013, 0}, {0.02, 0, 0}, {0.01, 0.01, 0}, {-1e-5, 0, 0}}) {
        const Eigen::Vector3d from(0.0131, 0.0112, 0.02);
        const auto [facet, weight] = place_at(mesh, surface, from);
        const FreeSurface::Walk walk = surface.walk(facet, weight, way);
        CHECK_FALSE(walk.at_border);
        CHECK(walk.walked_m == Approx(way.norm()).epsilon(1e-12));
        CHECK((point_of(mesh, walk) - (from + way)).norm() < 1e-15);
        CHECK((walk.along_m - way).norm() < 1e-15);
    }
    // a path through nodes, along the tangential part of a vector off the surface
    const auto [facet, weight] = place_at(mesh, surface, Eigen::Vector3d(0.01, 0.01, 0.02));
    CHECK((point_of(mesh, surface.walk(facet, weight, Eigen::Vector3d(0.02, 0.01, 0.5))) - Eigen::Vector3d(0.03, 0.02, 0.02)).norm() < 1e-15);
    const FreeSurface::Walk none = surface.walk(facet, weight, Eigen::Vector3d(0, 0, 0.5));
    CHECK(none.walked_m == 0);
    CHECK((point_of(mesh, none) - Eigen::Vector3d(0.01, 0.01, 0.02)).norm() < 1e-15);
}

TEST_CASE("a walk around an edge keeps its length and continues on the side; it stops at the fixed part", "[solid]") {
    const SpringMesh mesh = block();
    const FreeSurface surface(mesh);
    const auto [facet, weight] = place_at(mesh, surface, Eigen::Vector3d(0.033, 0.0112, 0.02));
    const FreeSurface::Walk over = surface.walk(facet, weight, Eigen::Vector3d(0.015, 0.003, 0));
    CHECK((point_of(mesh, over) - Eigen::Vector3d(0.04, 0.0142, 0.012)).norm() < 1e-15);
    CHECK((over.along_m - Eigen::Vector3d(0, 0.003, -0.015)).norm() < 1e-15);
    CHECK_FALSE(over.at_border);
    const FreeSurface::Walk held = surface.walk(facet, weight, Eigen::Vector3d(0.05, 0, 0));
    CHECK(held.at_border);
    CHECK(held.walked_m == Approx(0.027));
    CHECK((point_of(mesh, held) - Eigen::Vector3d(0.04, 0.0112, 0)).norm() < 1e-15);
    const auto bottom = std::find(surface.free_of().begin(), surface.free_of().end(), -1) - surface.free_of().begin();
    const FreeSurface::Walk stuck = surface.walk(static_cast<int>(bottom), {0.2, 0.3, 0.5}, Eigen::Vector3d(0.01, 0, 0));
    CHECK(stuck.at_border);
    CHECK(stuck.walked_m == 0);
    CHECK(stuck.facet == bottom);
}

TEST_CASE("a walk is reversible and stays on the surface; two half walks equal a whole one", "[solid]") {
    for (const SpringMesh& mesh : {block(), make_lattice("grid8", 4, 3, 0.04, 0.03)}) {
        const FreeSurface surface(mesh);
        const bool solid = mesh.is_solid();
        int far = 0;
        for (int i = 0; i < 300; ++i) {
            const int facet = i % static_cast<int>(mesh.facets.rows());
            if (surface.free_of()[static_cast<std::size_t>(facet)] < 0) continue;
            Eigen::Vector3d weight(0.2 + 0.001 * i, 0.3, solid ? 0.4 : 0);
            weight /= weight.sum();
            const Point along = solid ? Point(0.02 * Eigen::Vector3d(std::sin(1.0 * i), std::cos(1.0 * i), std::sin(2.3 * i))) : Point(0.02 * Eigen::Vector2d(std::sin(1.0 * i), std::cos(1.0 * i)));
            const FreeSurface::Walk there = surface.walk(facet, weight, along);
            CHECK(there.weight.minCoeff() >= 0);
            CHECK(there.weight.sum() == Approx(1).epsilon(tolerance::rounding));
            CHECK(surface.nearest(point_of(mesh, there)).distance_m < 1e-12);
            if (there.at_border) continue;
            far += there.walked_m > 0.01;
            const FreeSurface::Walk back = surface.walk(there.facet, there.weight, Point(-there.along_m));
            CHECK((point_of(mesh, back) - point_of(mesh, {facet, weight, along, 0, false})).norm() < 1e-12);
            const FreeSurface::Walk half = surface.walk(facet, weight, Point(along / 2));
            CHECK((point_of(mesh, surface.walk(half.facet, half.weight, half.along_m)) - point_of(mesh, there)).norm() < 1e-12);
        }
        CHECK(far > 40);
    }
}
