#include "springs/energy_model_terms.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "error.h"
#include "mesh/topology.h"
#include "springs/disc_rows.h"
#include "springs/heuristic.h"
#include "springs/isotropic_springs.h"
#include "springs/rest_place.h"

namespace tissue {
namespace {

const std::vector<std::string> patch_rows = {"normal", "tangent", "rotation", "stretch"};
const std::vector<std::string> disc_rows = {"normal", "tangent", "imprint_normal", "imprint_tangent", "hardening", "saturation", "coupling"};
const std::string support_term = "support.all";
// softening replaces hardening and saturation, compression replaces hardening
const std::string softening = "softening", compression = "compression";
const std::vector<std::string> patch_factors = {"", "phase", "corner", "edge"}, disc_factors = {"", "curved", "ground", "edge", "size"};
// depends on the radius, not on the place: resized() adds it to the rows before they are evaluated at a place
constexpr int size_factor = ContactParameters::factors;

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> parts{""};
    for (char c : text) {
        if (c == '.')
            parts.emplace_back();
        else
            parts.back() += c;
    }
    return parts;
}

/// Row and factor of a contact's term.
std::pair<int, int> patch_term(const std::string& term, const std::vector<std::string>& parts, const SpringMesh& mesh) {
    std::vector<std::string> rows = mesh.is_solid() ? disc_rows : patch_rows;
    const std::vector<std::string>& factors = mesh.is_solid() ? disc_factors : patch_factors;
    const std::string name = parts.size() > 1 ? parts[1] : "";
    if (mesh.is_solid()) rows.insert(rows.end(), {softening, compression});
    auto row = std::find(rows.begin(), rows.end(), name);
    const auto factor = parts.size() == 2 ? factors.begin() : std::find(factors.begin() + 1, factors.end(), parts.size() == 3 ? parts[2] : "");
    if (row == rows.end() || factor == factors.end())
        throw MismatchError(fmt::format("term '{}' is not known; allowed: contact. and one of {}, optionally followed by one of .{}", term,
                                        fmt::join(rows, ", "), fmt::join(factors.begin() + 1, factors.end(), ", .")));
    if (name == softening || name == compression) row = rows.begin() + ContactParameters::hardening_row;
    return {static_cast<int>(row - rows.begin()), static_cast<int>(factor - factors.begin())};
}

/// E2 of the cells [N/m]: of a lattice's squares, or of a shape's cells around nodes, as the mean over the node's
/// triangles by area.
Eigen::VectorXd cell_moduli(const SpringMesh& mesh, const Eigen::VectorXd& by_piece) {
    if (on_lattice(mesh)) return by_piece;
    const Cells triangles = mesh_cells(mesh);
    const Eigen::VectorXd areas = cell_areas(mesh, triangles);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.node_count()), area = sum;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        for (Eigen::Index k = 0; k < 3; ++k) {
            sum[triangles(t, k)] += areas[t] * by_piece[t];
            area[triangles(t, k)] += areas[t];
        }
    return sum.cwiseQuotient(area);
}

EnergyModelHeuristic assemble(const SpringMesh& mesh, const Eigen::VectorXd& springs, const Eigen::VectorXd& cell_modulus_N_m,
                      double contact_modulus_N_m, const std::string& formulation, double area_cap) {
    const bool strain = formulation == "plane-strain";
    if (!strain && formulation != "plane-stress")
        throw MismatchError(fmt::format("formulation '{}' is not known; allowed: plane-stress, plane-strain", formulation));
    if (!(area_cap > 1.0 / 3)) throw MismatchError(fmt::format("an area cap of {} E2 must be above E2 / 3", area_cap));
    EnergyModelHeuristic h;
    const Eigen::Index S = mesh.spring_count(), C = cell_modulus_N_m.size();
    h.incompressible = strain;
    const double share = on_lattice(mesh) ? 1 : 1.0 / 3;  // a shape's cells overlap in threes
    h.cap = share * area_cap * cell_modulus_N_m;
    const auto R = static_cast<Eigen::Index>(strain ? cell_regions(mesh, mesh_cells(mesh)).size() : 0);
    h.constants.resize(S + C + R);
    const Cells pieces = mesh_cells(mesh);
    const Eigen::VectorXd measure = isotropic_measure(mesh);
    h.constants.head(S) = 8.0 / 3 * cell_areas(mesh, pieces).sum() / measure.sum() * springs.cwiseProduct(measure.cwiseQuotient(mesh.incident_measure));
    h.constants.segment(S, C) = strain ? Eigen::VectorXd(start_below_cap * h.cap) : Eigen::VectorXd(share * cell_modulus_N_m / 3);
    h.constants.tail(R).setConstant(h.constants.segment(S, C).mean() / share);
    h.patch.log_N_m.col(0) << std::log(4 * contact_modulus_N_m), std::log(4 * contact_modulus_N_m),
        std::log(0.4 * contact_modulus_N_m), std::log(0.4 * contact_modulus_N_m);
    return h;
}

}  // namespace

double bent_factor(double x) { return 1 / (start_below_cap + (1 - start_below_cap) * std::exp(-x)); }

EnergyModelHeuristic energy_model_heuristic(const SpringMesh& mesh, double modulus_N_m, const std::string& formulation, double area_cap) {
    return assemble(mesh, heuristic_stiffness(mesh, modulus_N_m),
                    cell_moduli(mesh, Eigen::VectorXd::Constant(mesh_cells(mesh).rows(), modulus_N_m)), modulus_N_m, formulation, area_cap);
}

EnergyModelHeuristic energy_model_heuristic(const SpringMesh& mesh, const Eigen::VectorXd& triangle_modulus_N_m,
                           const std::string& formulation, double area_cap) {
    if (on_lattice(mesh)) throw MismatchError("a modulus by triangle needs springs on the triangles' edges");
    return assemble(mesh, heuristic_stiffness(mesh, triangle_modulus_N_m), cell_moduli(mesh, triangle_modulus_N_m),
                    triangle_modulus_N_m.maxCoeff(), formulation, area_cap);
}

EnergyModelHeuristic solid_heuristic(const SpringMesh& mesh, const Eigen::VectorXd& spring_modulus_Pa, const Eigen::VectorXd& cell_modulus_Pa,
                             double surface_modulus_Pa, double volume_cap, double radius_m, const Eigen::VectorXd& support_modulus_Pa) {
    if (mesh.embedding.empty()) throw MismatchError("a solid's heuristic needs an embedded lattice");
    if (!(volume_cap > 1.0 / 3)) throw MismatchError(fmt::format("a volume cap of {} E must be above E / 3", volume_cap));
    EnergyModelHeuristic h;
    h.cap = volume_cap * cell_modulus_Pa;
    Eigen::VectorXd supports = support_stiffness * surface_modulus_Pa / mesh.embedding.spacing_m * fixed_areas(mesh);
    if (support_modulus_Pa.size() > 0) supports = support_stiffness / mesh.embedding.spacing_m * fixed_areas(mesh).cwiseProduct(support_modulus_Pa);
    h.constants.resize(mesh.spring_count() + h.cap.size() + supports.size());
    const Eigen::VectorXd measure = isotropic_measure(mesh), unit = heuristic_stiffness(mesh, 1.0).cwiseProduct(measure).cwiseQuotient(mesh.incident_measure);
    // the measures sum to six times the volume
    h.constants.head(mesh.spring_count()) = 5.0 / 6 * unit.cwiseProduct(spring_modulus_Pa);
    h.constants.segment(mesh.spring_count(), h.cap.size()) = start_below_cap * h.cap;
    h.constants.tail(supports.size()) = supports;
    h.disc_radius_m = radius_m;
    h.spacing_m = mesh.embedding.spacing_m;
    h.patch.log_N_m.setZero(ContactParameters::disc_rows, ContactParameters::factors);
    h.patch.log_N_m.col(0) = start_of_disc(surface_modulus_Pa, radius_m, h.spacing_m);
    return h;
}

Eigen::VectorXd springs_alone(const SpringMesh& mesh, const Eigen::VectorXd& constants, const Eigen::VectorXd& springs_N_m) {
    Eigen::VectorXd other = Eigen::VectorXd::Zero(constants.size());
    other.head(mesh.spring_count()) = springs_N_m;
    other.tail(mesh.support_count()) = constants.tail(mesh.support_count());
    return other;
}

ContactCurve contact_curve(const std::vector<std::string>& terms) {
    for (const std::string& term : terms) {
        const std::vector<std::string> parts = split(term);
        if (parts.size() < 2 || parts[0] != "contact") continue;
        if (parts[1] == softening) return ContactCurve::softens;
        if (parts[1] == compression) return ContactCurve::compression;
    }
    return ContactCurve::hardens;
}

/// Throws MismatchError where terms contradict each other: a contact has one curve.
static void refuse_two_curves(const std::vector<std::string>& terms) {
    const ContactCurve curve = contact_curve(terms);
    if (curve == ContactCurve::hardens) return;
    for (const std::string& term : terms) {
        const std::vector<std::string> parts = split(term);
        if (parts.size() < 2 || parts[0] != "contact") continue;
        const bool saturates = parts[1] == "saturation" && curve == ContactCurve::softens;
        if (saturates || parts[1] == "hardening" || parts[1] == (curve == ContactCurve::softens ? compression : softening))
            throw MismatchError(fmt::format("term '{}': not possible with the other contact terms: use `hardening` with `saturation`, or `softening`; `compression` replaces `hardening`", term));
    }
}

bool is_size_term(const std::string& term) {
    const std::vector<std::string> parts = split(term);
    return parts.size() == 3 && parts[0] == "contact" && parts[2] == "size";
}

ContactParameters resized(ContactParameters contact_parameters, const std::vector<std::string>& terms, const Eigen::VectorXd& p, double own_m, double spacing_m, double log_times) {
    contact_parameters.log_N_m.col(0) += start_of_disc(1, own_m * std::exp(log_times), spacing_m) - start_of_disc(1, own_m, spacing_m);
    for (std::size_t t = 0; t < terms.size(); ++t) {
        if (!is_size_term(terms[t])) continue;
        const std::string name = split(terms[t])[1];
        const auto row = std::find(disc_rows.begin(), disc_rows.end(), name == softening || name == compression ? "hardening" : name);
        if (row != disc_rows.end()) contact_parameters.log_N_m(row - disc_rows.begin(), 0) += p[static_cast<Eigen::Index>(t)] * log_times;
    }
    return contact_parameters;
}

EnergyModelTerms::EnergyModelTerms(const SpringMesh& mesh, const EnergyModelHeuristic& heuristic, const std::vector<std::string>& terms)
    : terms_(terms), heuristic_(heuristic), springs_(mesh.spring_count()), value_(Eigen::MatrixXd::Zero(heuristic.constants.size(), static_cast<Eigen::Index>(terms.size()))) {
    const RestPlaces places(mesh);
    const Cells springs = mesh.springs;
    Cells cells = mesh_cells(mesh);
    if (!has_cells(mesh)) {  // a shape's cells lie around its nodes
        cells.resize(mesh.node_count(), 1);
        for (int node = 0; node < mesh.node_count(); ++node) cells(node, 0) = node;
    }
    if (heuristic.constants.size() != energy(mesh).constant_count() || heuristic.cap.size() != cells.rows())
        throw MismatchError("the constants of the heuristic do not match the mesh");
    if (mesh.is_solid()) refuse_two_curves(terms);
    curve_ = contact_curve(terms);
    for (std::size_t t = 0; t < terms.size(); ++t) {
        if (std::count(terms.begin(), terms.end(), terms[t]) > 1)
            throw MismatchError(fmt::format("term '{}' is present twice", terms[t]));
        const std::vector<std::string> parts = split(terms[t]);
        const auto column = static_cast<Eigen::Index>(t);
        on_patch_.emplace_back(-1, -1);
        if (parts[0] == "contact") {
            on_patch_.back() = patch_term(terms[t], parts, mesh);
            if (mesh.is_solid() && on_patch_.back().second == ContactParameters::ground_factor && heuristic.ground.rows() == 0)
                throw MismatchError(fmt::format("term '{}' is zero everywhere", terms[t]));
            continue;
        }
        if (is_skin_term(terms[t])) {
            if (!mesh.is_solid()) throw MismatchError(fmt::format("term '{}' needs a disc, and tissue in space", terms[t]));
            continue;
        }
        if (terms[t] == support_term) {
            if (mesh.support_count() == 0) throw MismatchError(fmt::format("term '{}' needs a solid in an embedded lattice", terms[t]));
            value_.col(column).tail(mesh.support_count()).setOnes();
            continue;
        }
        if ((parts[0] != "spring" && parts[0] != "cell") || parts.size() < 2)
            throw MismatchError(fmt::format("term '{}' is not known; allowed: spring., cell. or contact. and its factors, {}, {}", terms[t], support_term, fmt::join(skin_terms(), ", ")));
        const bool spring = parts[0] == "spring";
        auto value = value_.col(column).segment(spring ? 0 : springs.rows(), spring ? springs.rows() : cells.rows());
        value.setOnes();
        for (std::size_t f = 1; f < parts.size(); ++f) try {
                if (mesh.is_solid() && parts[f] == "nodule") {
                    if (heuristic.stiffer.size() == 0) value.setZero();
                    else value.array() *= heuristic.stiffer.segment(spring ? 0 : springs.rows(), value.size()).array();
                    continue;
                }
                value.array() *= places.factor(parts[f], spring ? springs : cells).array();
            } catch (const MismatchError& e) {
                throw MismatchError(fmt::format("term '{}': {}", terms[t], e.what()));
            }
        if (!(value.cwiseAbs().maxCoeff() > 0)) throw MismatchError(fmt::format("term '{}' is zero everywhere", terms[t]));
    }
}

Eigen::VectorXd EnergyModelTerms::constants(const Eigen::VectorXd& p) const {
    const Eigen::VectorXd exponent = value_ * p;
    const Eigen::Index C = heuristic_.cap.size();
    Eigen::VectorXd c = heuristic_.constants.array() * exponent.array().exp();
    // Logistic function of the exponent, bounded by the cap.
    for (Eigen::Index e = springs_; e < springs_ + C; ++e) {
        const double cap = heuristic_.cap[e - springs_];
        c[e] = cap / (1 + (cap / heuristic_.constants[e] - 1) * std::exp(-exponent[e]));
    }
    return c;
}

Eigen::MatrixXd EnergyModelTerms::constants_by(const Eigen::VectorXd& p) const {
    Eigen::VectorXd slope = constants(p);
    auto cells = slope.segment(springs_, heuristic_.cap.size()).array();
    cells *= 1 - cells / heuristic_.cap.array();
    return slope.asDiagonal() * value_;
}

ContactParameters EnergyModelTerms::patch(const Eigen::VectorXd& p, double log_times) const {
    ContactParameters contact_parameters = heuristic_.patch;
    contact_parameters.curve = curve_;
    for (std::size_t t = 0; t < on_patch_.size(); ++t)
        if (on_patch_[t].first >= 0 && on_patch_[t].second != size_factor) contact_parameters.log_N_m(on_patch_[t].first, on_patch_[t].second) += p[static_cast<Eigen::Index>(t)];
    return log_times == 0 ? contact_parameters : resized(contact_parameters, terms_, p, heuristic_.disc_radius_m, heuristic_.spacing_m, log_times);
}

Eigen::MatrixXd EnergyModelTerms::stiffness_by(const Eigen::VectorXd& p, const ContactFactors& factors, double log_scale, double log_times) const {
    const Eigen::VectorXd stiffness = patch(p, log_times).values_at(factors, log_scale);
    Eigen::MatrixXd by = Eigen::MatrixXd::Zero(stiffness.size(), size());
    for (std::size_t t = 0; t < on_patch_.size(); ++t)
        if (on_patch_[t].first >= 0)
            by(on_patch_[t].first, static_cast<Eigen::Index>(t)) = stiffness[on_patch_[t].first] * (on_patch_[t].second == size_factor ? log_times : factors[on_patch_[t].second]);
    return by;
}

}  // namespace tissue
