#pragma once

namespace tissue {

/// Factor s(e_0) of the coupling between the normal and the tangential gap of a disc's contact, coupling s(e_0)
/// (e_1^2 + e_2^2) / 2 (springs/contact_spring.h), and its derivatives. bound = 0: s = e_0. With bound = 2 coupling / k_t
///   s = e_0 for e_0 >= 0, and e_0 / (1 - bound e_0) else:
/// where the tool pulls, the tangential stiffness k_t + coupling s stays above k_t / 2 and the energy convex. The first
/// derivative is continuous.
struct ContactCoupling {
    double s, slope, curvature;     ///< s, ds/de_0, d2s/de_0^2
    double s_by_bound, slope_by_bound;

    ContactCoupling(double e_0, double bound) noexcept : s(e_0), slope(1), curvature(0), s_by_bound(0), slope_by_bound(0) {
        if (!(e_0 < 0) || bound == 0) return;
        const double q = 1 - bound * e_0;
        s = e_0 / q;
        slope = 1 / (q * q);
        curvature = 2 * bound / (q * q * q);
        s_by_bound = s * s;
        slope_by_bound = 2 * e_0 / (q * q * q);
    }
};

}  // namespace tissue
