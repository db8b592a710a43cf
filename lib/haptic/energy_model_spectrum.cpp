#include "haptic/energy_model_spectrum.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "error.h"
#include "haptic/spectrum.h"
#include "mesh/free_surface.h"
#include "springs/energy_model_kernel.h"
#include "springs/equilibrium_solver.h"

namespace tissue {
namespace {

/// A contact, and the directions of indentation there (unit vectors).
struct IndentationPlace {
    ContactSpring contact;
    std::vector<Point> ways;
};

/// In the plane: the corners and eight more places, straight in and 45 degrees to either side.
std::vector<IndentationPlace> places_along(const ContactSurface& surface, const ContactParameters& contact_parameters) {
    constexpr int evenly = 8;
    constexpr double slant = 0.7853981633974483;
    const Outline& outline = surface.outline();
    std::vector<double> arcs = outline.corners();
    for (int k = 0; k < evenly; ++k) arcs.push_back((k + 0.5) / evenly * outline.length());
    std::vector<IndentationPlace> places;
    for (double arc : arcs) {
        const ContactPatch patch = surface.at(arc);
        places.push_back({ContactSpring(PatchSpring(patch, contact_parameters.at(patch))), {}});
        for (double angle : {-slant, 0.0, slant}) places.back().ways.push_back(outline.direction(arc, angle));
    }
    return places;
}

/// Upper bound of the eigenvalues of M^-1 K, with K of the contact alone [1/s^2]: the Frobenius norm.
double swing(const RealtimeMesh& springs, const ContactSpring& contact) {
    const Eigen::Index n = contact.rows.pull.cols(), D = contact.rows.push.cols();
    Eigen::MatrixXd own = contact.tangent(Point::Zero(D), Eigen::VectorXd::Zero(n));
    for (Eigen::Index k = 0; k < n; ++k) {
        const double by_mass = std::sqrt(springs.inverse_mass()[contact.rows.nodes[static_cast<std::size_t>(k / D)]]);
        own.row(k) *= by_mass;
        own.col(k) *= by_mass;
    }
    return own.norm();
}

/// In space: first the place with the largest swing(), then those farthest from all places before; straight in and 30
/// degrees off.
std::vector<IndentationPlace> places_over(const SpringMesh& mesh, const RealtimeMesh& springs, const ContactKernel& kernel, const ContactParameters& contact_parameters) {
    const std::size_t few = mesh.node_count() - mesh.embedding.node_count() > 1500 ? 1 : 4;
    constexpr double slant = 0.5235987755982988;
    const FreeSurface surface(mesh);
    const std::vector<Point> points = surface.points(2);
    std::vector<double> away(points.size(), std::numeric_limits<double>::infinity());
    std::vector<IndentationPlace> places;
    std::size_t next = 0;
    double fastest = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const double here = swing(springs, ContactSpring(kernel.rows_at(points[k]), contact_parameters));
        if (here > fastest) {
            fastest = here;
            next = k;
        }
    }
    while (places.size() < std::min(few, points.size())) {
        const FreeSurface::Place at = surface.nearest(points[next]);
        const Eigen::Vector3d inward = at.inward;
        const Eigen::Vector3d along = inward.unitOrthogonal();
        places.push_back({ContactSpring(kernel.rows_at(at.point_m), contact_parameters), {inward, std::cos(slant) * inward + std::sin(slant) * along}});
        for (std::size_t k = 0; k < points.size(); ++k) away[k] = std::min(away[k], (points[k] - points[next]).norm());
        next = static_cast<std::size_t>(std::max_element(away.begin(), away.end()) - away.begin());
    }
    return places;
}

/// Stiffness of a contact while the nodes do not move, along the direction in which it is stiffest [N/m].
double at_once(const ContactSpring& contact, const EquilibriumState& state) {
    return contact.tool_force_by_push(state.push_m, contact.gather(state.displacement)).operatorNorm();
}

/// Tangent stiffness of the tissue with `tools` equal contacts at one place [N/m] (N*D x N*D).
Eigen::SparseMatrix<double> pressed(const TissueEnergy& energy, const Eigen::VectorXd& constants, const ContactSpring& contact, const EquilibriumState& state, int tools) {
    const int D = energy.dimension();
    const Eigen::MatrixXd own = tools * contact.tangent(state.push_m, contact.gather(state.displacement));
    const auto dof = [&](Eigen::Index k) { return D * contact.rows.nodes[static_cast<std::size_t>(k / D)] + static_cast<int>(k % D); };
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index a = 0; a < own.rows(); ++a)
        for (Eigen::Index b = 0; b < own.cols(); ++b) entries.emplace_back(dof(a), dof(b), own(a, b));
    const Eigen::SparseMatrix<double> tissue = energy.tangent(constants, state.displacement);
    Eigen::SparseMatrix<double> added(tissue.rows(), tissue.cols());
    added.setFromTriplets(entries.begin(), entries.end());
    return tissue + added;
}

}  // namespace

EnergyModelSpectrum energy_model_spectrum(const TissueModel& model, const RealtimeMesh& springs, int tools) {
    if (!model.energy_model) throw MismatchError("the model is not an energy model");
    const EnergyModel& energy_model = *model.energy_model;
    const TissueEnergy energy(model.mesh, energy_model);
    const auto kernel = make_contact_kernel(model.mesh, energy_model);
    const Eigen::SparseMatrix<double> at_rest = energy.tangent(energy_model.constants, NodeField::Zero(model.mesh.node_count(), model.mesh.dimension()));
    EnergyModelSpectrum spectrum{smallest_eigenvalue(springs, at_rest), largest_eigenvalue(springs, at_rest), 0, 0};

    const double depth_m = model.deepest_m();
    SolverOptions options;
    if (model.mesh.is_solid()) options.tolerance = 1e-4;  // gives frequencies to a thousandth
    EquilibriumSolver solver(energy, *kernel, options);
    EquilibriumState untouched;
    untouched.displacement = NodeField::Zero(model.mesh.node_count(), model.mesh.dimension());
    untouched.push_m = Point::Zero(model.mesh.dimension());
    for (const IndentationPlace& place : model.mesh.is_solid() ? places_over(model.mesh, springs, *kernel, energy_model.patch)
                                                    : places_along(static_cast<const ContactSurface&>(*kernel), energy_model.patch)) {
        const auto take = [&](const EquilibriumState& at) {
            const double here = largest_eigenvalue(springs, pressed(energy, energy_model.constants, place.contact, at, tools));
            if (here > spectrum.largest || std::isnan(here)) spectrum.largest = here;  // std::max would drop NaN
        };
        take(untouched);
        spectrum.contact_N_m = std::max(spectrum.contact_N_m, at_once(place.contact, untouched));
        for (const Point& way : place.ways) {
            const EquilibriumState state = solver.indent(energy_model.constants, place.contact, depth_m * way);
            if (state.push_m.norm() == 0) continue;  // no equilibrium at the first load step
            spectrum.contact_N_m = std::max(spectrum.contact_N_m, at_once(place.contact, state));
            take(state);
            spectrum.static_N_m = std::max(spectrum.static_N_m, state.contact_force_N.norm() / state.push_m.norm());
        }
    }
    return spectrum;
}

}  // namespace tissue
