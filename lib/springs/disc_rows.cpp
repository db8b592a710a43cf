#include "springs/disc_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "springs/polar_points.h"

namespace tissue {
namespace {

/// knot: where the mean begins to grow with the disc (PolarPoints::mean_m). last: largest radius of the fit. Both in
/// cube edges.
constexpr double knot = PolarPoints::mean_edges / PolarPoints::mean_radii, last = 2.5;

/// Compliance of a row in 1 / (E R) over x = R / h: a0 + a1 x + a2 x^2 + a3 x^3 up to the knot. Beyond it, that at the
/// knot times b0 + b1 y + b2 y^2 + (1 - b0 - b1 - b2) y^3, y = knot / x.
struct Compliance {
    double a0, a1, a2, a3, b0, b1, b2;

    double near(double x) const noexcept { return a0 + x * (a1 + x * (a2 + x * a3)); }
    double at(double x) const noexcept {
        if (x <= knot) return near(x);
        const double y = knot / std::min(x, last);
        return near(knot) * (b0 + y * (b1 + y * (b2 + y * (1 - b0 - b1 - b2))));
    }
    /// Log of the stiffness in E R.
    double log_stiffness(double x) const noexcept { return -std::log(at(x)); }
};

constexpr Compliance normal{1.2784, -1.0437, 0.1460, -0.0190, 0.2325, 1.4373, -1.5508};
constexpr Compliance tangent{2.9297, -2.2053, 0.3297, -0.0106, 0.2308, 0.9248, -0.4244};
constexpr Compliance imprint_normal{0.9409, -1.2668, 0.6177, -0.1073, -0.1250, 1.5783, -1.2526};
constexpr Compliance imprint_tangent{0.9934, -1.1892, 0.5805, -0.1049, -0.0070, 0.8861, 0.0760};

}  // namespace

ContactParameters::Start start_of_disc(double modulus_Pa, double radius_m, double spacing_m) noexcept {
    if (!(radius_m > 0 && spacing_m > 0)) return ContactParameters::Start::Constant(std::numeric_limits<double>::quiet_NaN());
    const double x = radius_m / spacing_m, in_ER = std::log(modulus_Pa * radius_m), in_ER3 = -in_ER - 2 * std::log(radius_m);
    const double mean = normal.log_stiffness(x), along = tangent.log_stiffness(x);
    ContactParameters::Start logs;
    logs << mean + in_ER, along + in_ER, imprint_normal.log_stiffness(x) + in_ER, imprint_tangent.log_stiffness(x) + in_ER, std::log(0.36) + mean + in_ER3, std::log(0.045) + mean + in_ER3,
        std::log(1.14 * modulus_Pa) + mean + 2 * along;
    return logs;
}

}  // namespace tissue
