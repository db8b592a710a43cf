#include "mesh/shape.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "../example.h"
#include "../refusal.h"
#include "disc.h"
#include "../tolerances.h"
#include "error.h"
#include "mesh/outline.h"
#include "springs/heuristic.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// A unit square in four triangles around a centre node, the last of them clockwise. The lower side is "base" and the
/// right triangle "hard"; node 9 is unused.
const std::string names = "1 1 \"base\"\n1 2 \"rest\"\n2 3 \"soft\"\n2 4 \"hard\"\n";
const std::string nodes = "1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0.5 0.5 0\n9 7 7 0\n";
const std::string elements =
    "1 1 2 1 1 1 2\n2 1 2 2 2 2 3\n3 1 2 2 2 3 4\n4 1 2 2 2 4 1\n"
    "5 2 2 3 1 1 2 5\n6 2 2 4 2 2 3 5\n7 2 2 3 1 3 4 5\n8 2 2 3 1 1 4 5\n";

std::string counted(const std::string& section, const std::string& lines) {
    return "$" + section + "\n" + std::to_string(std::count(lines.begin(), lines.end(), '\n')) + "\n" + lines + "$End" +
           section + "\n";
}

std::string square_text(const std::string& some_nodes = nodes, const std::string& some_elements = elements) {
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + counted("PhysicalNames", names) + counted("Nodes", some_nodes) +
           counted("Elements", some_elements);
}

MshFile read(const std::string& text) {
    TemporaryFolder folder;
    MshFile mesh = read_msh(folder.file("some.msh", text));
    mesh.file = "some.msh";
    return mesh;
}

Shape square(const std::string& text = square_text(), ShapeNotes* notes = nullptr) {
    return make_shape(read(text), {"base"}, {"hard"}, 0.1, notes);
}

}  // namespace

TEST_CASE("make_shape turns clockwise triangles, drops unused points, converts units and keeps edges and regions") {
    ShapeNotes notes;
    const Shape shape = square(square_text(), &notes);
    CHECK(notes.turned == 1);
    CHECK(notes.dropped == 1);
    CHECK(shape.nodes.rows() == 5);
    CHECK(shape.simplices.rows() == 4);
    CHECK(shape.nodes.maxCoeff() == Approx(0.1));
    CHECK(shape.region == std::vector<int>{0, 1, 0, 0});
    REQUIRE(shape.fixed_edges.size() == 1);
    for (int node : shape.fixed_edges[0]) CHECK(shape.nodes(node, 1) == 0);
    for (Eigen::Index t = 0; t < 4; ++t) {
        const Eigen::RowVector2d a = shape.nodes.row(shape.simplices(t, 0)), b = shape.nodes.row(shape.simplices(t, 1)) - a,
                                 c = shape.nodes.row(shape.simplices(t, 2)) - a;
        CHECK(b.x() * c.y() - b.y() * c.x() == Approx(0.005));
    }
}

TEST_CASE("edge_mesh has Euler's number of springs and areas (7) and (8) that sum to 3 and 1 times the area") {
    for (const Shape& shape : {square(), disc(24), shape_of(make_lattice("grid4", 6, 4, 0.1, 0.1))}) {
        const SpringMesh mesh = edge_mesh(shape);
        const auto T = static_cast<int>(mesh.simplices.rows());
        CHECK(mesh.topology == "edges");
        CHECK(mesh.spring_count() == mesh.node_count() + T - 1);
        double area = 0;
        for (std::size_t b = 0; b < mesh.loop().size(); ++b) {
            const Eigen::RowVector2d p = mesh.nodes.row(mesh.loop()[b]),
                                     q = mesh.nodes.row(mesh.loop()[(b + 1) % mesh.loop().size()]);
            area += (p.x() * q.y() - p.y() * q.x()) / 2;
        }
        CHECK(area > 0);
        CHECK(mesh.node_measure.sum() == Approx(area).epsilon(tolerance::rounding));
        CHECK(mesh.incident_measure.sum() == Approx(3 * area).epsilon(tolerance::rounding));
        std::set<std::pair<int, int>> pairs;
        for (int s = 0; s < mesh.spring_count(); ++s) CHECK(pairs.insert({mesh.springs(s, 0), mesh.springs(s, 1)}).second);
    }
}

TEST_CASE("a shape is read back from MSH bit by bit") {
    TemporaryFolder folder;
    for (const Shape& shape : {square(), disc(24)}) {
        const Shape back = read_shape(folder.file("mesh.msh", to_msh(shape, {"hard"})));
        CHECK(back.nodes == shape.nodes);
        CHECK(back.simplices == shape.simplices);
        CHECK(back.region == shape.region);
        CHECK(edge_mesh(back).loop() == edge_mesh(shape).loop());
        CHECK(edge_mesh(back).fixed == edge_mesh(shape).fixed);
    }
}

TEST_CASE("nodes are numbered along the longest axis for any orientation of a plane shape") {
    MshFile mesh = read(square_text());
    for (MshFile::Point& p : mesh.points) p = {p.x, 9 * p.y, 0};
    const Shape tall = make_shape(mesh, {"base"}, {}, 1);
    for (Eigen::Index i = 1; i < tall.nodes.rows(); ++i) CHECK(tall.nodes(i, 1) >= tall.nodes(i - 1, 1));
    // rotated by any angle: from left to right
    for (const double degrees : {20.0, 70.0, 110.0, 160.0, 200.0, 250.0, 290.0, 340.0}) {
        const double c = std::cos(degrees * 3.14159265358979323846 / 180), s = std::sin(degrees * 3.14159265358979323846 / 180);
        MshFile turned = mesh;
        for (MshFile::Point& p : turned.points) p = {c * p.x - s * p.y, s * p.x + c * p.y, 0};
        const Shape shape = make_shape(turned, {"base"}, {}, 1);
        const Eigen::RowVector2d along = Eigen::RowVector2d(-s, c) * (s > 0 ? -1 : 1);
        INFO(degrees << " degrees");
        for (Eigen::Index i = 1; i < shape.nodes.rows(); ++i) CHECK((shape.nodes.row(i) - shape.nodes.row(i - 1)).dot(along) >= -tolerance::rounding);
    }
}

TEST_CASE("a uniform modulus per triangle gives (7); a stiffer region stiffens only its own edges") {
    const Shape shape = square();
    const SpringMesh mesh = edge_mesh(shape);
    Eigen::VectorXd modulus = Eigen::VectorXd::Constant(4, 3.0);
    const Eigen::VectorXd even = heuristic_stiffness(mesh, 3.0);
    CHECK(heuristic_stiffness(mesh, modulus).isApprox(even, tolerance::rounding));
    for (Eigen::Index t = 0; t < 4; ++t)
        if (shape.region[static_cast<std::size_t>(t)] == 1) modulus[t] = 30;
    const Eigen::VectorXd uneven = heuristic_stiffness(mesh, modulus);
    std::multiset<int> ratios;
    for (int s = 0; s < mesh.spring_count(); ++s) ratios.insert(static_cast<int>(std::lround(10 * uneven[s] / even[s])));
    // 100: outer edge of the stiff triangle; 55: its two inner edges
    CHECK(ratios == std::multiset<int>{10, 10, 10, 10, 10, 55, 55, 100});
    CHECK_THROWS_AS(heuristic_stiffness(make_lattice("grid8", 1, 1, 1, 1), Eigen::VectorXd::Ones(2)), MismatchError);
}

TEST_CASE("inward normals of a polygonal disc point at its centre to 2e-3") {
    const Outline outline(edge_mesh(disc(24)));
    CHECK(outline.corners().empty());
    for (double arc = 0.015; arc < outline.length() - 0.015; arc += 0.0017) {
        const Eigen::Vector2d p = outline.position(arc);
        // normals of the sides are off by 0.13 at a node
        CHECK((outline.inward_normal(arc) + p.normalized()).norm() < 2e-3);
    }
}

TEST_CASE("an invalid mesh of a plane shape is refused with file, place and cause") {
    const auto said = [](const std::string& text) { return refusal<FileError>([&] { square(text); }); };
    const auto with_element = [](const std::string& line) { return square_text(nodes, elements + line + "\n"); };
    CHECK_THAT(said("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"), Contains(":2: ") && Contains("msh22"));
    CHECK_THAT(said("$MeshFormat\n2.2 1 8\n"), Contains(":2: ") && Contains("binary"));
    CHECK_THAT(said("solid\n"), Contains(":1: ") && Contains("not a gmsh mesh"));
    CHECK_THAT(said(square_text().substr(0, 300)), Contains("some.msh: is truncated: an element is missing"));
    CHECK_THAT(said(with(square_text(), "$Nodes\n6", "$Nodes\n1000001")), Contains("the number of nodes is 1000001; at most 1000000 are read"));
    CHECK_THAT(said(with_element("9 3 2 3 1 1 2 3 4")), Contains("element 9 is a quadrilateral"));
    CHECK_THAT(said(with_element("9 4 2 3 1 1 2 3 5")), Contains("element 9 is a tetrahedron"));
    CHECK_THAT(said(with_element("9 9 2 3 1 1 2 3 4 5 9")), Contains("second-order"));
    CHECK_THAT(said(with_element("9 2 2 3 1 1 2 6")), Contains("names node 6, which does not exist"));
    CHECK_THAT(said(with_element("9 2 2 3 1 1 3 5")), Contains("element 9") && Contains("no area"));
    CHECK_THAT(said(with_element("9 2 2 3 1 1 2 3")), Contains("two triangles overlap"));
    CHECK_THAT(said(square_text(with(nodes, "5 0.5 0.5 0", "5 0.5 0.5 0.2"))), Contains("not in the plane") && Contains("z = 0.02"));
    CHECK_THAT(said(square_text(with(nodes, "5 0.5 0.5 0", "5 0.5 nan 0"))), Contains("node 5") && Contains("finite"));
    CHECK_THAT(said(square_text(with(nodes, "5 0.5 0.5 0", "5 1.5 0.5 0"))), Contains("some.msh: two triangles overlap at the edge from (0.1, 0) m to (0.15, 0.05) m"));
    CHECK_THAT(said(square_text(with(nodes, "5 0.5 0.5 0", "5 0.5 -0.5 0"))), Contains("some.msh: two triangles overlap at the edge from (0.05, -0.05) m to (0.1, 0) m"));
    CHECK_THAT(said(square_text(nodes, elements.substr(0, elements.find("5 2")))), Contains("some.msh: has no triangles"));
    const std::string apart = nodes + "10 5 0 0\n11 6 0 0\n12 5 1 0\n";
    CHECK_THAT(said(square_text(apart, elements + "9 2 2 3 1 10 11 12\n")), Contains("one closed loop") && Contains("second part"));
    CHECK_THAT(said(square_text(apart, elements + "9 2 2 3 1 3 11 12\n")), Contains("touches itself at (0.1, 0.1) m"));
    const MshFile mesh = read(square_text());
    CHECK_THAT(refusal<FileError>([&] { make_shape(mesh, {"bottom"}, {}, 1); }),
               Contains("no physical curve 'bottom'; it has: base, rest"));
    CHECK_THAT(refusal<FileError>([&] { make_shape(mesh, {"base"}, {"tumour"}, 1); }),
               Contains("no physical surface 'tumour'; it has: soft, hard"));
    CHECK_THAT(refusal<FileError>([&] { make_shape(mesh, {"base", "rest"}, {}, 1); }), Contains("free surface"));
    CHECK_THAT(said(with_element("9 1 2 1 1 1 5")), Contains("fixed curve at") && Contains("not on the outline"));
}
