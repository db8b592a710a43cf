#include "springs/contact_spring.h"

#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

/// The plane's patch as rows. A node may stand twice at the surface's ends: there its weights add up.
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
    rows.pull.conservativeResize(4, static_cast<Eigen::Index>(2 * rows.nodes.size()));
    rows.law_row = {0, 1, 2, 3};
    rows.share = Eigen::VectorXd::Ones(4);
    rows.factors = PatchLaw::factors_at(patch);
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

ContactSpring::ContactSpring(ContactRows where, const PatchLaw& law) : rows(std::move(where)), k_N_m(rows.share.size()) {
    const Eigen::VectorXd values = law.values_at(rows.factors);
    for (Eigen::Index r = 0; r < k_N_m.size(); ++r) k_N_m[r] = rows.share[r] * values[rows.law_row[static_cast<std::size_t>(r)]];
    if (law.hardens()) hardening_1_J = values[PatchLaw::hardening_row];
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

ContactSpring::Load ContactSpring::load(const Point& push_m, const Eigen::VectorXd& u) const {
    const Eigen::VectorXd e = rows.push * push_m - rows.pull * u, q = k_N_m.cwiseProduct(e);
    const double s = q.dot(e) / 2, rise = 1 + hardening_1_J * s;
    return {s + hardening_1_J * s * s / 2, rise * (rows.push.transpose() * q), -rise * (rows.pull.transpose() * q)};
}

Eigen::MatrixXd ContactSpring::tangent(const Point& push_m, const Eigen::VectorXd& u) const {
    const Eigen::VectorXd e = rows.push * push_m - rows.pull * u, q = k_N_m.cwiseProduct(e);
    const Eigen::VectorXd s_by = rows.pull.transpose() * q;
    return (1 + hardening_1_J * q.dot(e) / 2) * (rows.pull.transpose() * k_N_m.asDiagonal() * rows.pull) +
           hardening_1_J * s_by * s_by.transpose();
}

Eigen::MatrixXd ContactSpring::hand_by_nodes(const Point& push_m, const Eigen::VectorXd& u) const {
    const Eigen::VectorXd e = rows.push * push_m - rows.pull * u, q = k_N_m.cwiseProduct(e);
    return -(1 + hardening_1_J * q.dot(e) / 2) * (rows.push.transpose() * k_N_m.asDiagonal() * rows.pull) -
           hardening_1_J * (rows.push.transpose() * q) * (rows.pull.transpose() * q).transpose();
}

ContactSpring::Load ContactSpring::by_law_row(int m, const Point& push_m, const Eigen::VectorXd& u) const {
    const Eigen::VectorXd e = rows.push * push_m - rows.pull * u, q = k_N_m.cwiseProduct(e);
    const double s = q.dot(e) / 2;
    if (m == PatchLaw::hardening_row) return {s * s / 2, s * (rows.push.transpose() * q), -s * (rows.pull.transpose() * q)};
    Eigen::VectorXd own = Eigen::VectorXd::Zero(e.size());  // d q / d stiffness
    for (Eigen::Index r = 0; r < e.size(); ++r)
        if (rows.law_row[static_cast<std::size_t>(r)] == m) own[r] = rows.share[r] * e[r];
    const double s_by = own.dot(e) / 2, rise = 1 + hardening_1_J * s;
    const Eigen::VectorXd all = rise * own + hardening_1_J * s_by * q;
    return {rise * s_by, rows.push.transpose() * all, -(rows.pull.transpose() * all)};
}

}  // namespace tissue
