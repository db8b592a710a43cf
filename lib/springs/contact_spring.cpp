#include "springs/contact_spring.h"

#include <algorithm>
#include <cmath>

#include "springs/contact_coupling.h"

namespace tissue {
namespace {

constexpr Eigen::Index mean_rows = 3;  // the first rows of a disc: normal and two tangents

/// The plane's patch as rows. At the surface's ends a node may occur twice; its weights are added.
ContactRows rows_of(const ContactPatch& patch) {
    ContactRows rows;
    rows.push.setZero(4, 2);
    rows.push.row(0) = patch.normal.transpose();
    rows.push.row(1) = patch.tangent.transpose();
    rows.pull.setZero(4, 2 * ContactPatch::size);
    for (int i = 0; i < ContactPatch::size; ++i) {
        const auto known = std::find(rows.nodes.begin(), rows.nodes.end(), patch.node[i]);
        const auto at = known - rows.nodes.begin();
        if (known == rows.nodes.end()) rows.nodes.push_back(patch.node[i]);
        rows.pull.block<1, 2>(0, 2 * at) += patch.weight[i] * patch.normal.transpose();
        rows.pull.block<1, 2>(1, 2 * at) += patch.weight[i] * patch.tangent.transpose();
        rows.pull.block<1, 2>(2, 2 * at) += patch.slope[i] * patch.normal.transpose();
        rows.pull.block<1, 2>(3, 2 * at) += patch.slope[i] * patch.tangent.transpose();
    }
    rows.mean = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rows.nodes.size()));
    for (int i = 0; i < ContactPatch::size; ++i)
        rows.mean[std::find(rows.nodes.begin(), rows.nodes.end(), patch.node[i]) - rows.nodes.begin()] += patch.weight[i];
    rows.log_scale = patch.log_scale;
    rows.pull.conservativeResize(4, static_cast<Eigen::Index>(2 * rows.nodes.size()));
    rows.parameter_row = {0, 1, 2, 3};
    rows.share = Eigen::VectorXd::Ones(4);
    rows.factors = ContactParameters::factors_at(patch);
    return rows;
}

}  // namespace

ContactRows ContactSurface::rows_at(const Point& contact_m) const { return rows_of(at(outline_.arc_of(contact_m))); }

std::vector<std::pair<int, int>> ContactSurface::coupled() const {
    const std::vector<int>& line = outline_.nodes();
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t i = 0; i < line.size(); ++i)
        for (std::size_t j = i; j < std::min(i + ContactPatch::size, line.size()); ++j) pairs.emplace_back(line[i], line[j]);
    return pairs;
}

ContactSpring::ContactSpring(ContactRows where, const ContactParameters& contact_parameters) : rows(std::move(where)), k_N_m(rows.share.size()) {
    parameter_value = contact_parameters.values_at(rows.factors, rows.log_scale);
    for (Eigen::Index r = 0; r < k_N_m.size(); ++r) k_N_m[r] = rows.share[r] * parameter_value[rows.parameter_row[static_cast<std::size_t>(r)]];
    if (!contact_parameters.hardens()) return;
    hardening_1_J = parameter_value[ContactParameters::hardening_row];
    saturation_1_J = parameter_value[ContactParameters::saturation_row];
    curve = contact_parameters.curve;
    if (curve == ContactCurve::softens) {
        saturation_1_J = hardening_1_J;
        hardening_1_J = -saturation_1_J;
    }
    coupling_N_m2 = parameter_value[ContactParameters::coupling_row];
}

ContactSpring::ContactSpring(const PatchSpring& patch) : rows(rows_of(patch.patch)), k_N_m(4) {
    k_N_m << patch.stiffness.normal, patch.stiffness.tangent, patch.stiffness.rotation, patch.stiffness.stretch;
}

Eigen::VectorXd ContactSpring::gather(const NodeField& u) const {
    const Eigen::Index D = u.cols();
    Eigen::VectorXd here(D * static_cast<Eigen::Index>(rows.nodes.size()));
    for (std::size_t i = 0; i < rows.nodes.size(); ++i) here.segment(D * static_cast<Eigen::Index>(i), D) = u.row(rows.nodes[i]).transpose();
    return here;
}

struct ContactSpring::State {
    Eigen::VectorXd e, q, mean;  // q = k e; mean: q in the rows that harden, else 0
    Eigen::Index hard;           // number of rows that harden, the first ones
    // s: energy of those rows; rise, bend: first and second derivative by s of the hardening energy
    double s, room, rise, bend;
    ContactCoupling coupling;

    State(const ContactSpring& c, const Point& push_m, const Eigen::VectorXd& u)
        : e(c.rows.push * push_m - c.rows.pull * u), q(c.k_N_m.cwiseProduct(e)), mean(Eigen::VectorXd::Zero(e.size())), coupling(e[0], c.coupling_bound()) {
        hard = c.curve != ContactCurve::compression ? std::min(mean_rows, e.size()) : e[0] > 0 ? 1 : 0;
        mean.head(hard) = q.head(hard);
        s = mean.dot(e) / 2;
        room = 1 + c.saturation_1_J * s;
        rise = c.hardening_1_J * (s + c.saturation_1_J * s * s / 2) / (room * room);
        bend = c.hardening_1_J / (room * room * room);
    }

    double across() const { return e.size() < 3 ? 0 : (e[1] * e[1] + e[2] * e[2]) / 2; }
    /// Gradient of e_0 (e_1^2 + e_2^2) / 2 by e.
    Eigen::VectorXd coupling_slope() const {
        Eigen::VectorXd slope = Eigen::VectorXd::Zero(e.size());
        slope.head<3>() << coupling.slope * across(), coupling.s * e[1], coupling.s * e[2];
        return slope;
    }
};

ContactSpring::Load ContactSpring::load(const Point& push_m, const Eigen::VectorXd& u) const {
    const State at(*this, push_m, u);
    Eigen::VectorXd slope = at.q + at.rise * at.mean;
    double energy = at.q.dot(at.e) / 2 + hardening_1_J * at.s * at.s / (2 * at.room);
    if (coupling_N_m2 != 0) {
        slope += coupling_N_m2 * at.coupling_slope();
        energy += coupling_N_m2 * at.coupling.s * at.across();
    }
    return {energy, rows.push.transpose() * slope, -(rows.pull.transpose() * slope)};
}

/// Second derivative of the energy by e, times e_by (R rows).
Eigen::MatrixXd ContactSpring::curvature_times(const Eigen::MatrixXd& e_by, const Point& push_m, const Eigen::VectorXd& u) const {
    const State at(*this, push_m, u);
    Eigen::MatrixXd product = k_N_m.asDiagonal() * e_by;
    const Eigen::Index mean = at.hard;
    product.topRows(mean) += at.rise * (k_N_m.head(mean).asDiagonal() * e_by.topRows(mean)) +
                             at.bend * at.mean.head(mean) * (at.mean.head(mean).transpose() * e_by.topRows(mean));
    if (coupling_N_m2 != 0) {
        Eigen::Matrix3d c;
        const ContactCoupling& k = at.coupling;
        c << k.curvature * at.across(), k.slope * at.e[1], k.slope * at.e[2], k.slope * at.e[1], k.s, 0, k.slope * at.e[2], 0, k.s;
        product.topRows<3>() += coupling_N_m2 * c * e_by.topRows<3>();
    }
    return product;
}

Eigen::MatrixXd ContactSpring::tangent(const Point& push_m, const Eigen::VectorXd& u) const {
    const Eigen::MatrixXd product = curvature_times(rows.pull, push_m, u);
    if (rows.touched.empty()) return rows.pull.transpose() * product;
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(product.cols(), product.cols());
    for (std::size_t g = 0; g < rows.touched.size(); ++g)
        for (int i : rows.touched[g])
            for (int j : rows.touched[g])
                sum.block<3, 3>(3 * i, 3 * j) += rows.pull.block<3, 3>(static_cast<Eigen::Index>(3 * g), 3 * i).transpose() * product.block<3, 3>(static_cast<Eigen::Index>(3 * g), 3 * j);
    return sum;
}

Eigen::MatrixXd ContactSpring::tool_force_by_nodes(const Point& push_m, const Eigen::VectorXd& u) const {
    return -(rows.push.transpose() * curvature_times(rows.pull, push_m, u));
}

Eigen::MatrixXd ContactSpring::tool_force_by_push(const Point& push_m, const Eigen::VectorXd& u) const {
    return rows.push.transpose() * curvature_times(rows.push, push_m, u);
}

ContactSpring::Load ContactSpring::by_parameter_row(int m, const Point& push_m, const Eigen::VectorXd& u) const {
    const State at(*this, push_m, u);
    const double s = at.s, sat = saturation_1_J;
    Eigen::VectorXd slope;  // derivative of dE/de by parameter_value[m]
    double energy = 0;
    // what the bound of the coupling changes, where it is changed by so much times coupling_N_m2
    const auto add_by_bound = [&](double bound_by) {
        energy += bound_by * at.coupling.s_by_bound * at.across();
        slope[0] += bound_by * at.coupling.slope_by_bound * at.across();
        slope.segment<2>(1) += bound_by * at.coupling.s_by_bound * at.e.segment<2>(1);
    };
    if (m == ContactParameters::hardening_row || m == ContactParameters::saturation_row) {
        const double harder = s * s / (2 * at.room), saturated = -hardening_1_J * s * s * s / (2 * at.room * at.room);
        const double harder_rise = (s + sat * s * s / 2) / (at.room * at.room);
        const double saturated_rise = -hardening_1_J * (1.5 * s * s + sat * s * s * s / 2) / (at.room * at.room * at.room);
        const bool softens = curve == ContactCurve::softens;
        // derivatives of hardening and saturation by the value of row m
        const double by_hardening = m == ContactParameters::saturation_row ? 0 : softens ? -1 : 1;
        const double by_saturation = softens == (m == ContactParameters::hardening_row) ? 1 : 0;
        energy = by_hardening * harder + by_saturation * saturated;
        slope = (by_hardening * harder_rise + by_saturation * saturated_rise) * at.mean;
    } else if (m == ContactParameters::coupling_row) {
        energy = at.coupling.s * at.across();
        slope = at.coupling_slope();
        if (curve == ContactCurve::compression) add_by_bound(2 * coupling_N_m2 / k_N_m[1]);
    } else {
        Eigen::VectorXd own = Eigen::VectorXd::Zero(at.e.size());
        for (Eigen::Index r = 0; r < own.size(); ++r)
            if (rows.parameter_row[static_cast<std::size_t>(r)] == m) own[r] = rows.share[r] * at.e[r];
        const Eigen::Index mean = at.hard;
        const double s_by = own.head(mean).dot(at.e.head(mean)) / 2;
        energy = own.dot(at.e) / 2 + at.rise * s_by;
        slope = own + at.bend * s_by * at.mean;
        slope.head(mean) += at.rise * own.head(mean);
        if (curve == ContactCurve::compression && m == rows.parameter_row[1]) add_by_bound(-2 * coupling_N_m2 * coupling_N_m2 * rows.share[1] / (k_N_m[1] * k_N_m[1]));
    }
    return {energy, rows.push.transpose() * slope, -(rows.pull.transpose() * slope)};
}

}  // namespace tissue
