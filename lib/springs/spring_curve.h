#pragma once

#include <array>
#include <limits>

namespace tissue {

/// How a spring that turns with the tissue pulls, per unit of stiffness: force over current length is
///   secant = (1 - r) P(r),   r = L / l,   P(r) = sum_k c_k r^k,   P(1) = 1,
/// l its length and L that at rest. Hooke's has P = 1: a force l - L. Stiffness at rest is 1 for every curve.
///
/// mooney_rivlin(): springs that are Mooney and Rivlin's material in the mean over all directions. For a deformation F and J = det F, in D dimensions, the mean over unit vectors n of
///   |F n|^2 is tr C / D,   of |F n|^-D it is 1 / J,   of |F n|^-(D+2) it is tr C^-1 / (D J)
/// (substitute m = F n / |F n|), so that springs of force, with s = l / L,
///   L [a (s - s^-(D+1)) + b (s^-(D+1) - s^-(D+3))],   (D + 2) a = 1 - q,   2 b = q
/// store, where J = 1, the energy of the material with C2 = q (C1 + C2) in D = 3, and bear nothing at rest. In plane strain C1 and C2 are one number, and every q is the same material.
///
/// Such a curve is used between two stretches, and beyond them its tangent. Below `straight_below`: a spring of half its length would be 26 (q = 0) to 320 (q = 1) times as stiff as at rest, and
/// time steps would have to be as short. Above `straight_above`, 1, springs are Hooke's: softer ones under tension leave a lattice whose cubes are as wide as the disc too little that resists a cube's hourglass modes. With
/// the whole curve the force of a disc of 10 mm on cubes of 10 mm, pushed by 14 mm, was 8 to 13 % low, or no rest was found; at smaller discs it was the same.
class SpringCurve {
   public:
    static constexpr int order = 6;
    static const double straight_below, straight_above;

    SpringCurve() = default;  ///< Hooke's
    /// q, 0 .. 1: share of C2; dimension 2 or 3; lengths over L where it goes straight on, one below 1 and one from 1 on. Throws MismatchError for others.
    static SpringCurve mooney_rivlin(double q, int dimension, double below = straight_below, double above = straight_above);

    bool hookean() const { return q_ < 0; }
    double q() const { return q_; }  ///< below 0 for Hooke's
    friend bool operator==(const SpringCurve& a, const SpringCurve& b) { return a.q_ == b.q_ && a.force_ == b.force_ && a.shorter_.stretch == b.shorter_.stretch && a.longer_.stretch == b.longer_.stretch; }

    /// Of a spring of length `rest` that is longer by `by` [m]; length above 0.
    double secant(double rest, double by) const noexcept;  ///< force over length
    double slope(double rest, double by) const noexcept;   ///< derivative of force by length
    double energy(double rest, double by) const noexcept;  ///< [m^2], 0 at rest

    /// The tangent at a stretch s_0 = l / L: force over L is pull + slope (s - s_0), energy over L^2 is stored + pull (s - s_0) + slope (s - s_0)^2 / 2.
    struct Tangent {
        double stretch, pull, slope, stored;

        double offset() const { return slope * stretch - pull; }  ///< secant = slope - offset r
        // s - s_0 from the strain s - 1, so that nothing cancels near rest
        double force_after(double strain) const { return pull + slope * (strain - (stretch - 1)); }
        double energy_after(double strain) const { return stored + (strain - (stretch - 1)) * (pull + slope / 2 * (strain - (stretch - 1))); }
    };

    /// For loops over many springs: coefficients of P, and of R with energy = by^2 R(r) / 2; and the tangents, of springs shorter than one stretch and longer than another.
    const std::array<double, order + 1>& force() const { return force_; }
    const std::array<double, order>& root() const { return root_; }
    const Tangent& shorter() const { return shorter_; }
    const Tangent& longer() const { return longer_; }

   private:
    Tangent tangent_at(double stretch) const;

    double q_ = -1;
    std::array<double, order + 1> force_{1};
    std::array<double, order> root_{1};
    Tangent shorter_{std::numeric_limits<double>::min(), 0, 1, 0}, longer_{std::numeric_limits<double>::max(), 0, 1, 0};  ///< no spring is so short or long
};

}  // namespace tissue
