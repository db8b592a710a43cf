#include "springs/turning_springs.h"

#include <algorithm>

namespace tissue {
namespace {

constexpr double no_length_m = 1e-12;  ///< least length of a spring

}  // namespace

TurningSprings::TurningSprings(const SpringMesh& mesh, const SpringCurve& curve)
    : Elements(mesh.springs), curve_(curve), span_(mesh.spring_count(), mesh.dimension()), length_(mesh.spring_count()) {
    for (int s = 0; s < mesh.spring_count(); ++s) {
        span_.row(s) = mesh.nodes.row(mesh.springs(s, 0)) - mesh.nodes.row(mesh.springs(s, 1));
        length_[s] = span_.row(s).norm();
    }
}

/// l - L = (l^2 - L^2) / (l + L): no cancellation, and exactly zero force at rest.
double TurningSprings::drawn_out(int e, const NodeField& u, double length) const {
    const auto relative = u.row(nodes()(e, 0)) - u.row(nodes()(e, 1));
    return std::max(relative.dot(2 * span_.row(e) + relative) / (length + length_[e]), no_length_m - length_[e]);
}

double TurningSprings::energy(int e, const NodeField& u) const {
    return curve_.energy(length_[e], drawn_out(e, u, (span_.row(e) + u.row(nodes()(e, 0)) - u.row(nodes()(e, 1))).norm()));
}

void TurningSprings::force(int e, const NodeField& u, ElementVector& out) const {
    const Eigen::Index D = u.cols();
    out.setZero(2 * D);
    out.head(D) = (span_.row(e) + u.row(nodes()(e, 0)) - u.row(nodes()(e, 1))).transpose();
    const double length = out.head(D).norm();
    // two nodes at the same place define no direction
    out.head(D) *= length > 0 ? curve_.secant(length_[e], drawn_out(e, u, length)) : 0;
    out.tail(D) = -out.head(D);
}

void TurningSprings::tangent(int e, const NodeField& u, ElementMatrix& out) const {
    const Eigen::Index D = u.cols();
    ElementVector axis = (span_.row(e) + u.row(nodes()(e, 0)) - u.row(nodes()(e, 1))).transpose();
    const double length = axis.norm();
    const double by = drawn_out(e, u, length);
    const double across = length > 0 ? curve_.secant(length_[e], by) : 1, along = length > 0 ? curve_.slope(length_[e], by) : 1;
    if (length > 0) axis /= length;
    out.setZero(2 * D, 2 * D);
    for (Eigen::Index a = 0; a < D; ++a)
        for (Eigen::Index b = 0; b < D; ++b) {
            const double k = (along - across) * axis[a] * axis[b] + (a == b ? across : 0);
            out(a, b) = out(D + a, D + b) = k;
            out(a, D + b) = out(D + a, b) = -k;
        }
}

}  // namespace tissue
