#include "haptic/law_spectrum.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "error.h"
#include "haptic/spectrum.h"
#include "mesh/free_surface.h"
#include "springs/law_kernel.h"
#include "springs/press.h"

namespace tissue {
namespace {

/// A contact, and ways to push there, unit vectors.
struct PressedPlace {
    ContactSpring contact;
    std::vector<Point> ways;
};

/// In the plane: corners and eight places more, straight in and 45 degrees to either side.
std::vector<PressedPlace> places_along(const ContactSurface& surface, const PatchLaw& law) {
    constexpr int evenly = 8;
    constexpr double slant = 0.7853981633974483;
    const Outline& outline = surface.outline();
    std::vector<double> arcs = outline.corners();
    for (int k = 0; k < evenly; ++k) arcs.push_back((k + 0.5) / evenly * outline.length());
    std::vector<PressedPlace> places;
    for (double arc : arcs) {
        const ContactPatch patch = surface.at(arc);
        places.push_back({ContactSpring(PatchSpring(patch, law.at(patch))), {}});
        for (double angle : {-slant, 0.0, slant}) places.back().ways.push_back(outline.direction(arc, angle));
    }
    return places;
}

/// How fast the nodes a contact holds swing on it alone [1/s^2]: never less than its fastest swing.
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

/// In space: few places, first where the contact swings fastest, then each farthest from those before; straight in and 30 degrees off.
std::vector<PressedPlace> places_over(const SpringMesh& mesh, const RealtimeMesh& springs, const ContactKernel& kernel, const PatchLaw& law) {
    const std::size_t few = mesh.node_count() - mesh.embedding.node_count() > 1500 ? 1 : 4;
    constexpr double slant = 0.5235987755982988;
    const FreeSurface surface(mesh);
    const std::vector<Point> points = surface.points(2);
    std::vector<double> away(points.size(), std::numeric_limits<double>::infinity());
    std::vector<PressedPlace> places;
    std::size_t next = 0;
    double fastest = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const double here = swing(springs, ContactSpring(kernel.rows_at(points[k]), law));
        if (here > fastest) {
            fastest = here;
            next = k;
        }
    }
    while (places.size() < std::min(few, points.size())) {
        const FreeSurface::Place at = surface.nearest(points[next]);
        const Eigen::Vector3d inward = at.inward;
        const Eigen::Vector3d along = inward.unitOrthogonal();
        places.push_back({ContactSpring(kernel.rows_at(at.point_m), law), {inward, std::cos(slant) * inward + std::sin(slant) * along}});
        for (std::size_t k = 0; k < points.size(); ++k) away[k] = std::min(away[k], (points[k] - points[next]).norm());
        next = static_cast<std::size_t>(std::max_element(away.begin(), away.end()) - away.begin());
    }
    return places;
}

/// Stiffness that a tool has on its contact while nodes stay where they are [N/m].
double at_once(const ContactSpring& contact, const PressState& state, const Point& way) {
    constexpr double little_m = 1e-6;
    const Eigen::VectorXd u = contact.gather(state.displacement);
    return (contact.load(state.push_m + little_m * way, u).hand_N - contact.load(state.push_m, u).hand_N).norm() / little_m;
}

/// The tangent of tissue and contacts, so many at the same place.
Eigen::SparseMatrix<double> pressed(const TissueEnergy& energy, const Eigen::VectorXd& constants, const ContactSpring& contact, const PressState& state, int tools) {
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

LawSpectrum law_spectrum(const TissueModel& model, const RealtimeMesh& springs, int tools) {
    if (!model.energy_law) throw MismatchError("the model's stiffness is no law");
    const LawModel& law = *model.energy_law;
    const TissueEnergy energy(model.mesh, law);
    const auto kernel = make_contact_kernel(model.mesh, law);
    const Eigen::SparseMatrix<double> at_rest = energy.tangent(law.constants, NodeField::Zero(model.mesh.node_count(), model.mesh.dimension()));
    LawSpectrum spectrum{smallest_eigenvalue(springs, at_rest), largest_eigenvalue(springs, at_rest), 0, 0};

    const double depth_m = model.deepest_m();
    PressOptions options;
    if (model.mesh.is_solid()) options.tolerance = 1e-4;  // for a thousandth of the frequency
    PressSolver solver(energy, *kernel, options);
    PressState untouched;
    untouched.displacement = NodeField::Zero(model.mesh.node_count(), model.mesh.dimension());
    untouched.push_m = Point::Zero(model.mesh.dimension());
    for (const PressedPlace& place : model.mesh.is_solid() ? places_over(model.mesh, springs, *kernel, law.patch)
                                                    : places_along(static_cast<const ContactSurface&>(*kernel), law.patch)) {
        const auto take = [&](const PressState& at) {
            const double here = largest_eigenvalue(springs, pressed(energy, law.constants, place.contact, at, tools));
            if (here > spectrum.largest || std::isnan(here)) spectrum.largest = here;  // std::max would lose what is no number
        };
        take(untouched);
        for (const Point& way : place.ways) {
            const PressState state = solver.press(law.constants, place.contact, depth_m * way);
            spectrum.contact_N_m = std::max(spectrum.contact_N_m, at_once(place.contact, untouched, way));
            if (state.push_m.norm() == 0) continue;  // lost at its first step
            spectrum.contact_N_m = std::max(spectrum.contact_N_m, at_once(place.contact, state, way));
            take(state);
            spectrum.static_N_m = std::max(spectrum.static_N_m, state.contact_force_N.norm() / state.push_m.norm());
        }
    }
    return spectrum;
}

}  // namespace tissue
