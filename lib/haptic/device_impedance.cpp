#include "haptic/device_impedance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

constexpr double share = 0.45;

/// Of (x_n, v_n, x_{n-1}, x_{n-2}) over a tick: whether it decays.
bool decays(const DeviceImpedance& device, double dt_s, double lead, double contact_N_m) {
    const double m = device.mass_kg, c = device.damping_Ns_m, decay = c * dt_s / m;
    // a mass with a damper under a force that is held for dt: exact
    const double kept = std::exp(-decay), coasted_s = c > 0 ? -std::expm1(-decay) * m / c : dt_s;
    const double pushed = decay > 1e-6 ? (dt_s - coasted_s) / c : dt_s * dt_s / (2 * m), sped = coasted_s / m;
    const Eigen::RowVector4d force = -contact_N_m * Eigen::RowVector4d(2 * lead, 0, 2 - 3 * lead, lead - 1);
    Eigen::Matrix4d step;
    step << 1, coasted_s, 0, 0,
            0, kept, 0, 0,
            1, 0, 0, 0,
            0, 0, 1, 0;
    step.row(0) += pushed * force;
    step.row(1) += sped * force;
    return step.eigenvalues().cwiseAbs().maxCoeff() < 1;
}

}  // namespace

DeviceImpedance stricter(DeviceImpedance said, const DeviceImpedance& known) {
    said.name = known.name;
    if (said.mass_kg == 0) said.mass_kg = known.mass_kg;
    if (said.damping_Ns_m == 0) said.damping_Ns_m = known.damping_Ns_m;
    said.stiffness_N_m = std::min(said.stiffness_N_m, known.stiffness_N_m);
    said.force_max_N = std::min(said.force_max_N, known.force_max_N);
    said.rate_Hz = std::min(said.rate_Hz, known.rate_Hz);
    return said;
}

double stable_stiffness_N_m(const DeviceImpedance& device, double dt_s, double lead) {
    const double unit_N_m = device.mass_kg / (dt_s * dt_s);
    double low = 1e-3, high = 16;  // of it
    if (!decays(device, dt_s, lead, low * unit_N_m)) return 0;
    for (int k = 0; k < 50; ++k) {
        const double middle = std::sqrt(low * high);
        (decays(device, dt_s, lead, middle * unit_N_m) ? low : high) = middle;
    }
    return share * low * unit_N_m;
}

}  // namespace tissue
