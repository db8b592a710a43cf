#include "springs/lattice_correction.h"

#include <catch2/catch.hpp>

#include "../mesh/dome.h"
#include "mesh/embedded_lattice.h"
#include "mesh/free_surface.h"
#include "springs/energy_model_terms.h"
#include "springs/indentation_solver.h"

using namespace tissue;

namespace {

constexpr double h = 0.012, radius_m = 0.007, E_Pa = 4524;

EnergyModel energy_model_on(const SpringMesh& mesh) {
    const Eigen::VectorXd springs = Eigen::VectorXd::Constant(mesh.spring_count(), E_Pa), cells = Eigen::VectorXd::Constant(mesh.embedding.cubes.rows(), E_Pa);
    const EnergyModelTerms model_terms(mesh, solid_heuristic(mesh, springs, cells, E_Pa, 12, radius_m), {"spring.all"});
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(1);
    return {model_terms.terms(), none, model_terms.constants(none), model_terms.patch(none), false, radius_m};
}

/// Trace of the stiffness against a small displacement of the tool [N/m].
double stiffness(const IndentationSolver& solver, const Point& place) {
    double trace = 0;
    for (int d = 0; d < 3; ++d) trace += solver.at(place, 1e-7 * Eigen::Vector3d::Unit(d)).contact_force[d] / 1e-7;
    return trace;
}

}  // namespace

TEST_CASE("the correction brings contact stiffness to the geometric mean over four shifted lattices", "[embedded][long]") {
    const Shape shape = dome(8);
    const SpringMesh mesh = embedded_lattice(shape, h);
    const FacetTable table = lattice_corrections(shape, mesh, energy_model_on, Eigen::VectorXd::Constant(1, radius_m), 2).at(0);
    REQUIRE(table.value.rows() == mesh.facets.rows());
    const FreeSurface surface(mesh);
    EnergyModel energy_model = energy_model_on(mesh), with_table = energy_model;
    with_table.disc.correction = table;
    const IndentationSolver plain(mesh, energy_model), corrected(mesh, with_table);
    std::vector<std::unique_ptr<IndentationSolver>> shifted;
    for (const Eigen::Vector3d& shift : {Eigen::Vector3d(0.5, 0.5, 0), Eigen::Vector3d(0.5, 0, 0.5), Eigen::Vector3d(0, 0.5, 0.5)}) {
        const SpringMesh moved = shifted_lattice(shape, h, shift);
        shifted.push_back(std::make_unique<IndentationSolver>(moved, energy_model_on(moved)));
    }
    double most_before = 0, most_after = 0, squares_before = 0, squares_between = 0;
    for (Eigen::Index free = 0; free < surface.facets().rows(); free += 29) {
        const bool at_corner = free % 2 == 0;  // a corner of the table; otherwise a point between
        const Point place = surface.at(free, at_corner ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d(0.5, 0.27, 0.23));
        const double own = std::log(stiffness(plain, place));
        double mean = own / 4;
        for (const auto& press : shifted) mean += std::log(stiffness(*press, place)) / 4;
        const double before = std::abs(own - mean), after = std::abs(std::log(stiffness(corrected, place)) - mean);
        if (at_corner) {
            most_before = std::max(most_before, before);
            most_after = std::max(most_after, after);
        } else {
            squares_before += before * before;
            squares_between += after * after;
        }
    }
    CAPTURE(most_before, most_after, squares_before, squares_between);
    CHECK(most_before > 0.01);
    CHECK(most_after < 0.1 * most_before);
    CHECK(squares_between < 0.25 * squares_before);
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f)
        if (surface.free_of()[static_cast<std::size_t>(f)] < 0) CHECK(table.value.row(f).isZero(0));
}

TEST_CASE("corrections of a disc do not depend on other discs or on the number of threads", "[embedded][long]") {
    const Shape shape = dome(14);
    const SpringMesh mesh = embedded_lattice(shape, 2 * h);
    const std::vector<FacetTable> tables = lattice_corrections(shape, mesh, energy_model_on, Eigen::Vector2d(0.005, radius_m), 2);
    REQUIRE(tables.size() == 2);
    CHECK(lattice_corrections(shape, mesh, energy_model_on, Eigen::VectorXd::Constant(1, radius_m), 1)[0].value == tables[1].value);
    CHECK(tables[0].value != tables[1].value);
}

TEST_CASE("a shifted lattice is offset by the given part of an edge and contains the same volume of tissue", "[embedded]") {
    const Shape shape = dome(8);
    const SpringMesh mesh = embedded_lattice(shape, h), moved = shifted_lattice(shape, h, Eigen::Vector3d(0.5, 0.25, 0));
    const auto corner = [](const SpringMesh& of) { return Eigen::Vector3d(of.nodes.row(of.embedding.cubes(0, 0)).transpose()); };
    const Eigen::Vector3d by = (corner(moved) - corner(mesh)) / h;
    CHECK(std::abs(by[0] - std::floor(by[0]) - 0.5) < 1e-9);
    CHECK(std::abs(by[1] - std::floor(by[1]) - 0.25) < 1e-9);
    CHECK(std::abs(by[2] - std::round(by[2])) < 1e-9);
    CHECK(moved.embedding.fraction.sum() == Approx(mesh.embedding.fraction.sum()).epsilon(0.01));
}
