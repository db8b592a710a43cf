#include "cases/study_energy_model.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "error.h"
#include "io/one_line.h"
#include "mesh/cells.h"
#include "mesh/facet.h"
#include "mesh/open_faces.h"
#include "mesh/region_lookup.h"

namespace tissue {

namespace {

const Study::MaterialParameters& parameters_of(const Study& study, int region) {
    if (region == 0) return study.material;
    if (static_cast<std::size_t>(region) > study.material.regions.size())
        throw MismatchError(fmt::format("the shape has region {}, and study '{}' only {}", region, study.name, study.material.regions.size()));
    return study.material.regions[static_cast<std::size_t>(region - 1)];
}

}  // namespace

Eigen::VectorXd triangle_moduli(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double modulus_N_m) {
    Eigen::VectorXd modulus = Eigen::VectorXd::Constant(mesh.simplices.rows(), modulus_N_m);
    if (study.material.regions.empty()) return modulus;
    for (Eigen::Index t = 0; t < modulus.size(); ++t) {
        const Study::MaterialParameters& own = parameters_of(study, shape->region[static_cast<std::size_t>(t)]);
        modulus[t] = modulus_N_m * own.youngs_modulus_Pa() / study.material.youngs_modulus_Pa();
    }
    return modulus;
}

namespace {

/// Weights of a tetrahedron's corners at points spread evenly over it, `along` of them along an edge (P x 4).
Eigen::MatrixXd even_in_tetrahedron(int along) {
    Eigen::MatrixXd weights(along * (along + 1) * (along + 2) / 6, 4);
    Eigen::Index p = 0;
    for (int i = 0; i < along; ++i)
        for (int j = 0; i + j < along; ++j)
            for (int k = 0; i + j + k < along; ++k) weights.row(p++) << i + 0.25, j + 0.25, k + 0.25, along - 1 - i - j - k + 0.25;
    return weights / along;
}

/// Weights of the K nodes of a spring or cell at evenly spread points, 4 along each axis (P x K).
Eigen::MatrixXd even_points(Eigen::Index corners) {
    constexpr int along = 4;
    int axes = 0;  // 2^axes nodes; bit a of a node's number is its end along axis a
    while ((1 << axes) < corners) ++axes;
    int points = 1;
    for (int a = 0; a < axes; ++a) points *= along;
    Eigen::MatrixXd weights = Eigen::MatrixXd::Ones(points, corners);
    for (int p = 0; p < points; ++p)
        for (Eigen::Index k = 0; k < corners; ++k)
            for (int a = 0, rest = p; a < axes; ++a, rest /= along) {
                const double w = (rest % along + 0.5) / along;
                weights(p, k) *= (k >> a & 1) ? w : 1 - w;
            }
    return weights;
}

double volume_of(const SpringMesh& mesh, Eigen::Index tetrahedron) {
    const auto at = [&](int k) { return Eigen::RowVector3d(mesh.nodes.row(mesh.simplices(tetrahedron, k))); };
    return (at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) / 6;
}

NodeField places_of(const SpringMesh& mesh, const Cells& pieces, Eigen::Index e) {
    NodeField corners(pieces.cols(), mesh.dimension());
    for (Eigen::Index k = 0; k < pieces.cols(); ++k) corners.row(k) = mesh.nodes.row(pieces(e, k));
    return corners;
}

/// Parts of each spring or cell that lie in the base material and in each region (P x (1 + R)).
Eigen::MatrixXd parts_by_region(const Shape& shape, Eigen::Index regions, const SpringMesh& mesh, const Cells& pieces) {
    const RegionLookup lookup(shape);
    const Eigen::MatrixXd weights = even_points(pieces.cols());
    Eigen::MatrixXd part = Eigen::MatrixXd::Zero(pieces.rows(), 1 + regions);
    // Region of the tetrahedron at a face, by its sorted nodes; filled when needed.
    std::map<std::array<int, 3>, int> behind;
    for (Eigen::Index e = 0; e < pieces.rows(); ++e) {
        const Eigen::MatrixXd at = weights * places_of(mesh, pieces, e);
        for (Eigen::Index p = 0; p < at.rows(); ++p)
            if (const auto region = lookup.inside(at.row(p).transpose())) part(e, *region) += 1;
        if (const double found = part.row(e).sum(); found > 0) {
            part.row(e) /= found;
            continue;
        }
        const auto sorted = [](std::array<int, 3> face) {
            std::sort(face.begin(), face.end());
            return face;
        };
        if (behind.empty())
            for (Eigen::Index t = 0; t < shape.simplices.rows(); ++t)
                for (const auto& face : tetrahedron_faces)
                    behind[sorted({shape.simplices(t, face[0]), shape.simplices(t, face[1]), shape.simplices(t, face[2])})] = shape.region[static_cast<std::size_t>(t)];
        const Eigen::Vector3d middle_m = at.colwise().mean().transpose();
        double least_m = std::numeric_limits<double>::infinity();
        Eigen::Index nearest = 0;
        for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f)
            if (const double away_m = nearest_on_facet(mesh.nodes, mesh.facets, f, middle_m).distance_m; away_m < least_m) {
                least_m = away_m;
                nearest = f;
            }
        part(e, behind.at(sorted({mesh.facets(nearest, 0), mesh.facets(nearest, 1), mesh.facets(nearest, 2)}))) = 1;
    }
    return part;
}

}  // namespace

Eigen::VectorXd fraction_inside(const SpringMesh& mesh, const Cells& pieces, const Inclusion& inclusion) {
    const Eigen::MatrixXd weights = even_points(pieces.cols());
    Eigen::VectorXd part = Eigen::VectorXd::Zero(pieces.rows());
    for (Eigen::Index e = 0; e < pieces.rows(); ++e) {
        const Eigen::MatrixXd at = weights * places_of(mesh, pieces, e);
        for (Eigen::Index p = 0; p < at.rows(); ++p)
            part[e] += inclusion.contains(at.row(p).transpose()) ? 1.0 / static_cast<double>(at.rows()) : 0.0;
    }
    return part;
}

Eigen::VectorXd solid_moduli(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, const Cells& pieces) {
    const double E = study.material.youngs_modulus_Pa();
    Eigen::VectorXd own = Eigen::VectorXd::Constant(pieces.rows(), E);
    const auto in_no_cell = [&](const std::string& key, const std::string& volume) {
        throw StudyError(one_line(fmt::format("{}: key '{}': no point of the lattice's cubes ({:g} mm, 64 points each) is in {}; make springs.spacing_m smaller", study.file, key,
                                              1e3 * study.springs.spacing_m, volume)));
    };
    const bool cells = pieces.cols() > 2;
    if (study.nodule) {
        const Eigen::VectorXd inside = fraction_inside(mesh, pieces, study.nodule->inclusion);
        if (cells && !study.nodule->shape.empty() && inside.isZero(0)) in_no_cell("nodule.shape", study.nodule->shape);
        own += (study.nodule->youngs_modulus_Pa() - E) * inside;
    }
    if (study.material.regions.empty()) return own;
    for (int region : shape->region) parameters_of(study, region);  // throws for a region that the study does not name
    const Eigen::MatrixXd part = parts_by_region(*shape, static_cast<Eigen::Index>(study.material.regions.size()), mesh, pieces);
    Eigen::VectorXd moduli(part.cols());
    for (Eigen::Index r = 0; r < part.cols(); ++r) {
        moduli[r] = parameters_of(study, static_cast<int>(r)).youngs_modulus_Pa();
        if (r > 0 && cells && part.col(r).isZero(0) && std::count(shape->region.begin(), shape->region.end(), static_cast<int>(r)) > 0)
            in_no_cell("material.regions." + study.material.regions[static_cast<std::size_t>(r - 1)].name, "this region of " + study.geometry.shape);
    }
    return part * moduli;
}

NodeField nodule_points(const Study& study) {
    constexpr int least_across = 8, most_across = 64;
    constexpr std::size_t least = 50;  // with fewer points in the nodule the grid is refined
    const Inclusion& nodule = study.nodule->inclusion;
    const Eigen::Array3d middle_m = (nodule.low_m() + nodule.high_m()) / 2, half_m = (nodule.high_m() - nodule.low_m()) / 2;
    std::vector<Eigen::Vector3d> places;
    for (int across = least_across; places.size() < least && across <= most_across; across *= 2) {
        places.clear();
        for (int i = 0; i < across * across * across; ++i) {
            const Eigen::Array3d at = (2 * Eigen::Array3d(i % across, i / across % across, i / across / across) + 1) / across - 1;
            const Eigen::Vector3d place_m = middle_m + half_m * at;
            if (nodule.contains(place_m)) places.push_back(place_m);
        }
    }
    if (places.empty()) throw StudyError(one_line(fmt::format("{}: key 'nodule.shape': {} is too thin: a grid of {} points across its bounding box has no point inside", study.file, study.nodule->shape, most_across)));
    NodeField points(static_cast<Eigen::Index>(places.size()), 4);
    for (Eigen::Index g = 0; g < points.rows(); ++g)
        points.row(g) << places[static_cast<std::size_t>(g)].transpose(),
            nodule.volume_m3() / static_cast<double>(places.size()) * std::log(study.nodule->youngs_modulus_Pa() / study.material.youngs_modulus_Pa());
    return points;
}

NodeField region_points(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh) {
    const Eigen::MatrixXd weights = even_in_tetrahedron(2);
    const double E = study.material.youngs_modulus_Pa();
    const Eigen::VectorXd own = triangle_moduli(study, shape, mesh, E);
    std::vector<Eigen::RowVector4d> points;
    for (Eigen::Index t = 0; t < own.size(); ++t) {
        if (shape->region[static_cast<std::size_t>(t)] == 0) continue;
        Eigen::Matrix<double, 4, 3> corners;
        for (int k = 0; k < 4; ++k) corners.row(k) = mesh.nodes.row(mesh.simplices(t, k));
        const Eigen::MatrixXd at = weights * corners;
        const double part_m3 = volume_of(mesh, t) / static_cast<double>(at.rows());
        for (Eigen::Index p = 0; p < at.rows(); ++p)
            points.emplace_back(at(p, 0), at(p, 1), at(p, 2), part_m3 * std::log(own[t] / E));
    }
    NodeField field(static_cast<Eigen::Index>(points.size()), 4);
    for (std::size_t g = 0; g < points.size(); ++g) field.row(static_cast<Eigen::Index>(g)) = points[g];
    return field;
}

namespace {

/// E at each fixed node [Pa] (M): the mean over its tetrahedra, weighted by volume. Empty where it is the base
/// material's everywhere.
Eigen::VectorXd tissue_at_supports(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double modulus_Pa) {
    if (study.material.regions.empty()) return {};
    const Eigen::VectorXd own = triangle_moduli(study, shape, mesh, modulus_Pa);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.embedding.node_count()), volume = sum;
    for (Eigen::Index t = 0; t < mesh.simplices.rows(); ++t)
        for (int node : mesh.simplices.row(t)) {
            sum[node] += own[t] * volume_of(mesh, t);
            volume[node] += volume_of(mesh, t);
        }
    return sum(mesh.fixed).cwiseQuotient(volume(mesh.fixed));
}

/// Modulus of each support [Pa] (M); the stiffness of a support is 8 modulus area / spacing. On a rigid bed the modulus
/// is the tissue's E there. On an elastic bed it is smaller, so that the support has the stiffness of the rigid bed's
/// support and of the bed in series. Where parts meet it is the mean weighted by area. Empty where it is the base
/// material's E everywhere.
Eigen::VectorXd support_moduli(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double modulus_Pa) {
    Eigen::VectorXd moduli = tissue_at_supports(study, shape, mesh, modulus_Pa);
    const std::vector<double> beds = study.geometry.beds_Pa_m();
    if (beds.empty()) return moduli;
    if (moduli.size() == 0) moduli.setConstant(static_cast<Eigen::Index>(mesh.fixed.size()), modulus_Pa);
    const std::vector<int> parts = study.geometry.beds();
    // All fixed parts lie on one bed.
    const bool one = beds.size() == 1 && std::count(parts.begin(), parts.end(), 0) == 0;
    if (!shape || (!one && shape->bed.size() != shape->fixed_facets.size())) throw MismatchError("the mesh of the shape is older than the study's beds: make it again (make mesh)");
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(moduli.size()), area = sum, least = Eigen::VectorXd::Constant(moduli.size(), std::numeric_limits<double>::infinity()), most = -least;
    for (std::size_t f = 0; f < shape->fixed_facets.size(); ++f) {
        const auto& corners = shape->fixed_facets[f];
        const Eigen::Vector3d a = shape->nodes.row(corners[0]), b = shape->nodes.row(corners[1]), c = shape->nodes.row(corners[2]);
        const double own = (b - a).cross(c - a).norm();
        const int bed = one ? 1 : shape->bed[f];
        if (bed < 0 || bed > static_cast<int>(beds.size())) throw MismatchError(fmt::format("the mesh of the shape has a bed {}, and the study has {} beds: make the mesh again (make mesh)", bed, beds.size()));
        for (int node : corners) {
            const auto m = std::lower_bound(mesh.fixed.begin(), mesh.fixed.end(), node) - mesh.fixed.begin();
            const double rigid = moduli[m], bed_Pa = bed > 0 ? beds[static_cast<std::size_t>(bed) - 1] * mesh.embedding.spacing_m / support_stiffness : 0;
            const double here = bed > 0 ? rigid * bed_Pa / (rigid + bed_Pa) : rigid;
            sum[m] += own * here;
            area[m] += own;
            least[m] = std::min(least[m], here);
            most[m] = std::max(most[m], here);
        }
    }
    return (least.array() == most.array()).select(least, sum.cwiseQuotient(area));
}

/// Force curve of all springs. Regions and a nodule have their own moduli, but the base material's C2 / (C1 + C2).
SpringCurve curve_of(const Study& study, const SpringMesh& mesh) {
    // Factor of C2 / (C1 + C2), because the lattice has springs in 26 directions, not in all. It is fitted so that they
    // are nearest to the material in uniaxial stretch and pure shear of 0.6 to 1.4.
    constexpr double of_lattice = 0.3;
    return study.springs.hookean ? SpringCurve() : SpringCurve::mooney_rivlin(of_lattice * study.material.second_share(), mesh.dimension());
}

/// The energy model of a solid. Springs, cells, supports and contacts depend on the stiffness of the regions or nodule.
EnergyModelTerms solid_law(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double factor) {
    const double E = factor * study.material.youngs_modulus_Pa();
    const Eigen::VectorXd springs = factor * solid_moduli(study, shape, mesh, mesh.springs),
                          cells = factor * solid_moduli(study, shape, mesh, mesh_cells(mesh));
    EnergyModelHeuristic heuristic = solid_heuristic(mesh, springs, cells, E, study.springs.area_cap_E2, study.indenter.radius_m, support_moduli(study, shape, mesh, E));
    heuristic.curve = curve_of(study, mesh);
    if (study.nodule || !study.material.regions.empty()) {
        heuristic.stiffer.resize(springs.size() + cells.size());
        heuristic.stiffer << (springs / E).array().log(), (cells / E).array().log();
        heuristic.ground = study.nodule ? nodule_points(study) : region_points(study, shape, mesh);
    }
    return {mesh, heuristic, study.springs.terms};
}

/// A stiffness of each constant of the energy model except supports, linear in the moduli of the study's materials.
/// Only ratios of such stiffnesses are used, so the unit does not matter.
Eigen::VectorXd stiffness_of(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh) {
    if (!mesh.is_solid())
        return energy_model_heuristic(mesh, triangle_moduli(study, shape, mesh, study.modulus_N_m()), study.material.formulation, study.springs.area_cap_E2).constants;
    const Eigen::VectorXd springs = solid_moduli(study, shape, mesh, mesh.springs),
                          cells = solid_moduli(study, shape, mesh, mesh_cells(mesh));
    Eigen::VectorXd all(springs.size() + cells.size());
    all << springs, cells;
    return all;
}

/// Multiplies all moduli of a material by `share`.
void take_share(Study::MaterialParameters& p, double share) {
    p.C1_Pa *= share;
    p.C2_Pa *= share;
    for (double& mu : p.mu_Pa) mu *= share;
}

}  // namespace

Relaxation study_relaxation(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, const EnergyModelTerms& model_terms) {
    Relaxation r;
    if (!study.material.relaxes() || study.material.fits_shares) return r;
    const auto K = static_cast<Eigen::Index>(study.material.viscosity.size());
    r.tau_s.resize(K);
    r.contact_share.resize(K);
    const Eigen::Index constants = model_terms.energy(mesh).constant_count(), supports = mesh.support_count();
    r.share.setZero(constants, K);  // supports do not relax
    for (Eigen::Index k = 0; k < K; ++k) {
        const auto b = static_cast<std::size_t>(k);
        r.tau_s[k] = study.material.viscosity[b].tau_s;
        r.contact_share[k] = study.material.viscosity[b].share;
        const auto has_own = [&](const Study::MaterialParameters& p) { return p.share[b] != study.material.viscosity[b].share; };
        bool uniform = !study.nodule || !has_own(*study.nodule);
        for (const Study::Region& region : study.material.regions) uniform = uniform && !has_own(region);
        if (uniform) {
            r.share.col(k).head(constants - supports).setConstant(r.contact_share[k]);
            continue;
        }
        // The study with the moduli of this branch alone. A base material without it keeps 1e-12 of its moduli, because
        // the regions' moduli are computed as ratios to the base material's.
        Study part = study;
        const double least = 1e-12;
        take_share(part.material, std::max(study.material.viscosity[b].share, least));
        for (Study::Region& region : part.material.regions) take_share(region, std::max(region.share[b], least));
        if (part.nodule) take_share(*part.nodule, std::max(part.nodule->share[b], least));
        r.share.col(k).head(constants - supports) = stiffness_of(part, shape, mesh).cwiseQuotient(stiffness_of(study, shape, mesh));
    }
    return r;
}

EnergyModelTerms study_energy_model(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double factor) {
    if (mesh.is_solid()) return solid_law(study, shape, mesh, factor);
    const double modulus_N_m = factor * study.modulus_N_m(), cap = study.springs.area_cap_E2;
    const std::string& formulation = study.material.formulation;
    EnergyModelHeuristic heuristic =
        study.material.regions.empty() ? energy_model_heuristic(mesh, modulus_N_m, formulation, cap)
                                       : energy_model_heuristic(mesh, triangle_moduli(study, shape, mesh, modulus_N_m), formulation, cap);
    heuristic.curve = curve_of(study, mesh);
    return {mesh, heuristic, study.springs.terms};
}

}  // namespace tissue
