#include "mesh/free_surface.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "mesh/facet.h"
#include "mesh/mesh_fault.h"
#include "mesh/topology.h"
#include "../tolerances.h"

using namespace tissue;

namespace {

SpringMesh block() { return make_lattice("grid26", Lattice{{4, 3, 2}, {0.04, 0.03, 0.02}}); }

}  // namespace

TEST_CASE("the free surface of a solid is all but its bottom, and knows the nearest point and the way in", "[solid]") {
    const SpringMesh mesh = block();
    const FreeSurface surface(mesh);
    CHECK(surface.held_facets().rows() == 2 * 4 * 3);
    CHECK(surface.facets().rows() + surface.held_facets().rows() == mesh.facets.rows());
    CHECK(surface.spacing_m() == Approx(0.01).epsilon(tolerance::rounding));
    CHECK(seen_nodes(mesh) == surface.nodes());
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

TEST_CASE("a point off a triangle's face is nearest to its side or corner", "[solid]") {
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

TEST_CASE("a solid's mesh with a fault says which part is wrong", "[solid]") {
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
