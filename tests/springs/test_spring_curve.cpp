#include "springs/spring_curve.h"

#include <catch2/catch.hpp>
#include <Eigen/Dense>
#include <cmath>

#include "../refusal.h"
#include "error.h"

using namespace tissue;

namespace {

constexpr double L = 0.01;

/// Mean over all directions of a spring's energy per length squared under the deformation F: 600 x 400 points on the
/// sphere, 400 on the circle.
double mean_energy(const SpringCurve& curve, const Eigen::MatrixXd& F) {
    constexpr int around = 400, across = 600;
    double sum = 0, weights = 0;
    for (int j = 0; j < (F.rows() == 3 ? across : 1); ++j)
        for (int k = 0; k < around; ++k) {
            const double angle = 2 * M_PI * (k + 0.5) / around, z = F.rows() == 3 ? -1 + 2 * (j + 0.5) / across : 0, out = std::sqrt(1 - z * z);
            Eigen::VectorXd n(F.rows());
            n.head(2) << out * std::cos(angle), out * std::sin(angle);
            if (F.rows() == 3) n[2] = z;
            sum += curve.energy(1, (F * n).norm() - 1);
            weights += 1;
        }
    return sum / weights;
}

/// Stretch above which the curve is linear, below the one where its stiffness would vanish.
double most_of(double q) { return q < 0.7 ? 3 : 1.22; }

/// Deformations without change of volume: uniaxial, pure shear and, in space, simple shear.
std::vector<Eigen::MatrixXd> isochoric(int dimension) {
    std::vector<Eigen::MatrixXd> all;
    if (dimension == 2) {
        for (const double s : {0.8, 1.2, 1.5}) all.push_back(Eigen::Vector2d(s, 1 / s).asDiagonal());
        return all;
    }
    for (const double s : {0.75, 0.9, 1.3, 1.7}) all.push_back(Eigen::Vector3d(s, 1 / std::sqrt(s), 1 / std::sqrt(s)).asDiagonal());
    all.push_back(Eigen::Vector3d(1.4, 1, 1 / 1.4).asDiagonal());
    Eigen::Matrix3d sheared = Eigen::Matrix3d::Identity();
    sheared(0, 2) = 0.4;
    all.push_back(sheared);
    return all;
}

}  // namespace

TEST_CASE("averaged over all directions the spring curve is a Mooney-Rivlin material", "[curve]") {
    for (const double q : {0.0, 0.3, 1.0}) {  // linear only beyond all of these stretches
        const SpringCurve curve = SpringCurve::mooney_rivlin(q, 3, 0.3, most_of(q));
        for (const Eigen::MatrixXd& F : isochoric(3)) {
            const Eigen::Matrix3d C = F.transpose() * F;
            if (std::sqrt(C.operatorNorm()) > most_of(q)) continue;
            INFO("q = " << q << ", F =\n" << F);
            // Small strains: springs of unit stiffness store 2/15 strain : strain / 2, the material with C1 + C2 = 1
            // stores 2 strain : strain.
            const double material = (1 - q) * (C.trace() - 3) + q * (C.inverse().trace() - 3);
            CHECK(mean_energy(curve, F) == Approx(material / 30).epsilon(2e-4));
        }
    }
    for (const double q : {0.0, 0.5, 1.0})  // in plane strain the material is the same for every q
        for (const Eigen::MatrixXd& F : isochoric(2)) {
            if (F.operatorNorm() > most_of(q)) continue;
            CHECK(mean_energy(SpringCurve::mooney_rivlin(q, 2, 0.3, most_of(q)), F) == Approx(((F.transpose() * F).trace() - 2) / 16).epsilon(1e-6));
        }
}

TEST_CASE("a curve's force is the derivative of its energy and its slope that of the force; also where linear", "[curve]") {
    std::vector<SpringCurve> curves = {SpringCurve()};
    for (const int dimension : {2, 3})
        for (const double q : {0.0, 0.4, 1.0})
            for (const double above : {SpringCurve::straight_above, 1.1, q < 1 ? 1.9 : 1.15}) curves.push_back(SpringCurve::mooney_rivlin(q, dimension, SpringCurve::straight_below, above));
    for (const SpringCurve& curve : curves) {
        CHECK(curve.energy(L, 0) == 0);
        CHECK(curve.secant(L, 0) == 0);
        CHECK(curve.slope(L, 0) == Approx(1).epsilon(1e-12));  // Hooke's stiffness at rest
        for (const double s : {0.1, 0.4, SpringCurve::straight_below - 1e-4, SpringCurve::straight_below + 1e-4, 0.8, 0.999, 1 - 1e-7, 1 + 1e-7, 1.001, 1.3, 2.5}) {
            INFO("q = " << curve.q() << " at " << s << ", linear above " << curve.longer().stretch);
            const double by = (s - 1) * L, little = 1e-8 * L;
            const auto force = [&](double b) { return curve.secant(L, b) * (L + b); };
            CHECK((curve.energy(L, by + little) - curve.energy(L, by - little)) / (2 * little) == Approx(force(by)).epsilon(1e-6).margin(1e-12));
            CHECK((force(by + little) - force(by - little)) / (2 * little) == Approx(curve.slope(L, by)).epsilon(1e-6));
            CHECK(curve.energy(L, by) > 0);
        }
    }
    // Hooke's curve
    CHECK(SpringCurve().hookean());
    CHECK(SpringCurve().energy(L, -0.9 * L) == Approx(0.405 * L * L));
    CHECK(SpringCurve().secant(L, 3 * L) == Approx(0.75));
    // formula of the force, for a spring at 0.8 of its length
    const double s = 0.8, neo = (s - std::pow(s, -4)) / 5, second = (std::pow(s, -4) - std::pow(s, -6)) / 2;
    CHECK(SpringCurve::mooney_rivlin(0.25, 3).secant(L, (s - 1) * L) * s == Approx(0.75 * neo + 0.25 * second));
    // the polynomial R for loops: 2 energy = by^2 R(r), r = 1 / s
    const auto& w = SpringCurve::mooney_rivlin(0.25, 2).root();
    double R = 0;
    for (std::size_t k = w.size(); k-- > 0;) R = R / s + w[k];
    CHECK(SpringCurve::mooney_rivlin(0.25, 2).energy(L, (s - 1) * L) == Approx(std::pow((s - 1) * L, 2) * R / 2));
}

TEST_CASE("invalid parameters of a spring curve are refused", "[curve]") {
    CHECK_THAT(refusal<MismatchError>([] { SpringCurve::mooney_rivlin(1.01, 3); }), Catch::Contains("1.01"));
    CHECK_THAT(refusal<MismatchError>([] { SpringCurve::mooney_rivlin(std::nan(""), 3); }), Catch::Contains("nan"));
    CHECK_THAT(refusal<MismatchError>([] { SpringCurve::mooney_rivlin(0.5, 4); }), Catch::Contains("4"));
    CHECK_THAT(refusal<MismatchError>([] { SpringCurve::mooney_rivlin(0.5, 3, 0.6, 0.9); }), Catch::Contains("0.9"));
    CHECK_THAT(refusal<MismatchError>([] { SpringCurve::mooney_rivlin(1, 3, 0.6, 1.9); }), Catch::Contains("soften above 1.9"));
    CHECK_THAT(refusal<MismatchError>([] { SpringCurve::mooney_rivlin(0.5, 3, 0, 1); }), Catch::Contains("below 0"));
}
