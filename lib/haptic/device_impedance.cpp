#include "haptic/device_impedance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

constexpr double share = 0.45;  // of the stiffness at the limit of stability: margin for late ticks

/// Whether the state (x_n, v_n, x_{n-1}, x_{n-2}, .. x_{n-late-2}) decays: the matrix of a tick has a spectral radius
/// below 1. late: the delay in periods. Allocates nothing, since a session calls it when it takes over a device.
template <int late>
bool decays(const DeviceImpedance& device, double dt_s, double lead, double contact_N_m) {
    using Row = Eigen::Matrix<double, 1, 4 + late>;
    const double m = device.mass_kg, c = device.damping_Ns_m, decay = c * dt_s / m;
    // exact solution of a mass with a damper under a force that is constant over dt
    const double kept = std::exp(-decay), coasted_s = c > 0 ? -std::expm1(-decay) * m / c : dt_s;
    const double pushed = decay > 1e-6 ? (dt_s - coasted_s) / c : dt_s * dt_s / (2 * m), sped = coasted_s / m;
    const auto past = [](int k) { return k == 0 ? 0 : 1 + k; };  // index of x_{n-k} in the state
    Row tool = Row::Zero(), before = tool;  // end positions of the tool, in this tick and in the one before
    tool[past(late)] = 2 + late;
    tool[past(late + 1)] = -1 - late;
    before[past(late + 1)] = 2 + late;
    before[past(late + 2)] = -1 - late;
    const Row force = -contact_N_m * (lead * tool + (1 - lead) * before);
    Eigen::Matrix<double, 4 + late, 4 + late> step = Eigen::Matrix<double, 4 + late, 4 + late>::Zero();
    step(0, 0) = 1;
    step(0, 1) = coasted_s;
    step(1, 1) = kept;
    for (int k = 1; k <= late + 2; ++k) step(past(k), past(k - 1)) = 1;
    step.row(0) += pushed * force;
    step.row(1) += sped * force;
    return step.eigenvalues().cwiseAbs().maxCoeff() < 1;
}

bool decays(const DeviceImpedance& device, double dt_s, double lead, double contact_N_m) {
    const double periods = std::ceil(device.delay_s / dt_s - 1e-9);
    if (periods <= 0) return decays<0>(device, dt_s, lead, contact_N_m);
    if (periods == 1) return decays<1>(device, dt_s, lead, contact_N_m);
    if (periods == 2) return decays<2>(device, dt_s, lead, contact_N_m);
    return periods == 3 && decays<3>(device, dt_s, lead, contact_N_m);  // a longer delay counts as unstable
}

}  // namespace

DeviceImpedance stricter(DeviceImpedance said, const DeviceImpedance& known) {
    said.name = known.name;
    if (said.mass_kg == 0) said.mass_kg = known.mass_kg;
    if (said.damping_Ns_m == 0) said.damping_Ns_m = known.damping_Ns_m;
    said.stiffness_N_m = std::min(said.stiffness_N_m, known.stiffness_N_m);
    said.force_max_N = std::min(said.force_max_N, known.force_max_N);
    said.rate_Hz = std::min(said.rate_Hz, known.rate_Hz);
    said.delay_s = std::max(said.delay_s, known.delay_s);
    return said;
}

double stable_stiffness_N_m(const DeviceImpedance& device, double dt_s, double lead) {
    const double unit_N_m = device.mass_kg / (dt_s * dt_s);
    double low = 1e-3, high = std::max(16.0, 4 * device.damping_Ns_m * dt_s / device.mass_kg);  // in units of unit_N_m
    if (!decays(device, dt_s, lead, low * unit_N_m)) return 0;
    for (int k = 0; k < 50; ++k) {
        const double middle = std::sqrt(low * high);
        (decays(device, dt_s, lead, middle * unit_N_m) ? low : high) = middle;
    }
    return share * low * unit_N_m;
}

}  // namespace tissue
