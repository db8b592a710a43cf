#pragma once

#include <array>
#include <limits>

namespace tissue {

/// Force curve of a spring that rotates with the tissue, per unit stiffness. Force over current length is
///   secant = (1 - r) P(r),   r = L / l,   P(r) = sum_k c_k r^k,   P(1) = 1,
/// with the current length l and the rest length L. Hooke's spring has P = 1: a force l - L. Every curve has stiffness
/// 1 at rest.
///
/// mooney_rivlin(): springs whose mean over all directions is a Mooney-Rivlin material. For a deformation F with J =
/// det F in D dimensions, the mean over unit vectors n is
///   tr C / D of |F n|^2,   1 / J of |F n|^-D,   tr C^-1 / (D J) of |F n|^-(D+2)
/// (by the substitution m = F n / |F n|). Springs with the force, at s = l / L,
///   L [a (s - s^-(D+1)) + b (s^-(D+1) - s^-(D+3))],   (D + 2) a = 1 - q,   2 b = q
/// therefore store, at J = 1 and D = 3, the energy of the material with C2 = q (C1 + C2), and have no force at rest. In
/// plane strain C1 and C2 have the same effect, and every q gives the same material.
///
/// The curve is used between two stretches; outside it continues as its tangent. Below `straight_below`: a spring of
/// half its length would be 26 (q = 0) to 320 (q = 1) times as stiff as at rest, and time steps would have to be
/// shorter accordingly. Above `straight_above` = 1 springs are Hooke's. The curve softens under tension, which leaves
/// too little resistance to the hourglass modes of the cubes where these are as wide as the disc. With the whole curve
/// the force of a disc of 10 mm on cubes of 10 mm, displaced by 14 mm, was 8 to 13 % low, or no equilibrium was found.
/// Smaller discs showed the same.
class SpringCurve {
   public:
    static constexpr int order = 6;
    static const double straight_below, straight_above;

    SpringCurve() = default;  ///< Hooke's
    /// q: share of C2, 0 .. 1. dimension: 2 or 3. below, above: stretches l / L at which the curve continues as its
    /// tangent, 0 < below < 1 and above >= 1. Throws MismatchError for other values, and where the stiffness at `above`
    /// is negative.
    static SpringCurve mooney_rivlin(double q, int dimension, double below = straight_below, double above = straight_above);

    bool hookean() const { return q_ < 0; }
    double q() const { return q_; }  ///< below 0 for Hooke's springs
    friend bool operator==(const SpringCurve& a, const SpringCurve& b) { return a.q_ == b.q_ && a.force_ == b.force_ && a.shorter_.stretch == b.shorter_.stretch && a.longer_.stretch == b.longer_.stretch; }

    /// Values for a spring of rest length `rest` that is longer by `by` [m]; rest + by > 0.
    double secant(double rest, double by) const noexcept;  ///< force over length
    double slope(double rest, double by) const noexcept;   ///< derivative of force by length
    double energy(double rest, double by) const noexcept;  ///< [m^2], 0 at rest

    /// Tangent at a stretch s_0 = l / L: force over L is pull + slope (s - s_0), energy over L^2 is stored + pull (s -
    /// s_0) + slope (s - s_0)^2 / 2.
    struct Tangent {
        double stretch, pull, slope, stored;

        double offset() const { return slope * stretch - pull; }  ///< secant = slope - offset r
        // s - s_0 is computed from the strain s - 1: no cancellation near rest.
        double force_after(double strain) const { return pull + slope * (strain - (stretch - 1)); }
        double energy_after(double strain) const { return stored + (strain - (stretch - 1)) * (pull + slope / 2 * (strain - (stretch - 1))); }
    };

    /// For loops over many springs: coefficients of P; coefficients of R with energy = by^2 R(r) / 2; the tangents for
    /// short and for long springs.
    const std::array<double, order + 1>& force() const { return force_; }
    const std::array<double, order>& root() const { return root_; }
    const Tangent& shorter() const { return shorter_; }
    const Tangent& longer() const { return longer_; }

   private:
    Tangent tangent_at(double stretch) const;

    double q_ = -1;
    std::array<double, order + 1> force_{1};
    std::array<double, order> root_{1};
    /// default: no spring is so short or so long
    Tangent shorter_{std::numeric_limits<double>::min(), 0, 1, 0}, longer_{std::numeric_limits<double>::max(), 0, 1, 0};
};

}  // namespace tissue
