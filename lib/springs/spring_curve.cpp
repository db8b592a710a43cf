#include "springs/spring_curve.h"

#include <fmt/format.h>

#include "error.h"

namespace tissue {
namespace {

template <std::size_t N>
double polynomial(const std::array<double, N>& c, double r) {
    double sum = 0;
    for (std::size_t k = N; k-- > 0;) sum = sum * r + c[k];
    return sum;
}

template <std::size_t N>
double derivative(const std::array<double, N>& c, double r) {
    double sum = 0;
    for (std::size_t k = N; k-- > 1;) sum = sum * r + static_cast<double>(k) * c[k];
    return sum;
}

}  // namespace

const double SpringCurve::straight_below = 0.6, SpringCurve::straight_above = 1.0;

SpringCurve SpringCurve::mooney_rivlin(double q, int dimension, double below, double above) {
    if (!(q >= 0 && q <= 1)) throw MismatchError(fmt::format("the share of C2 is {}, must be in 0 .. 1", q));
    if (dimension != 2 && dimension != 3) throw MismatchError(fmt::format("springs in {} dimensions are not possible", dimension));
    if (!(below > 0 && below < 1 && above >= 1)) throw MismatchError(fmt::format("a curve that is straight below {} and above {} is not possible", below, above));
    const auto D = static_cast<std::size_t>(dimension);
    const double a = (1 - q) / (dimension + 2), b = q / 2;
    SpringCurve curve;
    curve.q_ = q;
    // (1 - r^(D+2)) / (1 - r) and (r^(D+2) - r^(D+4)) / (1 - r).
    curve.force_ = {};
    for (std::size_t k = 0; k < D + 2; ++k) curve.force_[k] = a;
    curve.force_[D + 2] = curve.force_[D + 3] = b;
    // s^2 / 2 + s^-D / D - 1/2 - 1/D and s^-(D+2) / (D+2) - s^-D / D + 1/D - 1/(D+2), both over (s - 1)^2 / 2.
    if (dimension == 3) {
        curve.root_ = {a, 2 * a, 4 * a / 3 + 4 * b / 15, 2 * a / 3 + 8 * b / 15, 12 * b / 15, 6 * b / 15};
    } else {
        curve.root_ = {a, 2 * a, a + b / 2, b, b / 2, 0};
    }
    const Tangent shorter = curve.tangent_at(below), longer = curve.tangent_at(above);
    if (longer.slope < 0) throw MismatchError(fmt::format("springs with a share of C2 of {} soften above {} of their length until they have no stiffness", q, above));
    curve.shorter_ = shorter;
    curve.longer_ = longer;
    return curve;
}

SpringCurve::Tangent SpringCurve::tangent_at(double stretch) const {
    const double by = stretch - 1;
    return {stretch, stretch * secant(1, by), slope(1, by), energy(1, by)};
}

double SpringCurve::secant(double rest, double by) const noexcept {
    const double strain = by / rest, r = 1 / (1 + strain);
    if (1 + strain < shorter_.stretch) return shorter_.force_after(strain) * r;
    if (1 + strain > longer_.stretch) return longer_.force_after(strain) * r;
    return strain * r * polynomial(force_, r);
}

double SpringCurve::slope(double rest, double by) const noexcept {
    const double strain = by / rest, r = 1 / (1 + strain);
    if (1 + strain < shorter_.stretch) return shorter_.slope;
    if (1 + strain > longer_.stretch) return longer_.slope;
    return polynomial(force_, r) - strain * r * r * derivative(force_, r);
}

double SpringCurve::energy(double rest, double by) const noexcept {
    const double strain = by / rest;
    if (1 + strain < shorter_.stretch) return rest * rest * shorter_.energy_after(strain);
    if (1 + strain > longer_.stretch) return rest * rest * longer_.energy_after(strain);
    return by * by / 2 * polynomial(root_, 1 / (1 + strain));
}

}  // namespace tissue
