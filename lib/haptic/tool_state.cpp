#include "haptic/tool_state.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tissue {

ToolState::ToolState(const HapticOptions& given, int dimension, std::vector<ToolMemory> memory_of_mesh)
    : options(given), safety(given.safety), memory(std::move(memory_of_mesh)), friction(given.friction) {
    record.master_m = record.proxy_m = record.contact_displacement_m = record.coupling_N = record.measured_N = Point::Zero(dimension);
    no_contact(record.proxy_m);
    velocity_m_s = went_m = slid_m = slide_m_s = Point::Zero(dimension);
}

void ToolState::fields(StateBytes& state) noexcept {
    DeviceImpedance& device = options.device;
    ToolSpring::Growth growth = spring.growth();
    state(options.map, device.mass_kg, device.damping_Ns_m, device.stiffness_N_m, device.force_max_N, device.rate_Hz, device.delay_s, safety, same_position_s, old_s, expected_s, stood_s, device_m, has_master,
          clutched, grasp_asked, grasps, let_go, options.grasp_max_N, taken_over, carried_N, carried, contact, touched, coupling_N_m, memory, at_m, went_m, share, slid_m, slide_m_s, velocity_m_s, touched_m, friction, armed, unarmed, untouched_s, record, growth);
    if (!state.reads()) return;
    options.friction = friction.options();
    options.safety = safety.options();
    spring.grow(growth);
}

Point ToolState::at_the_end(const Point& master_m, double period_s) const noexcept {
    return master_m + (period_s + old_s + std::min(same_position_s, expected_s)) * velocity_m_s;
}

void ToolState::follow_hand(const Point& moved_m, double age_s) noexcept {
    const double most = options.safety.speed_max_m_s * options.map.scale, between_s = safety.between_s();
    if (!safety.has_motion()) {
        velocity_m_s.setZero();
        expected_s = same_position_s = old_s = 0;
    } else if (between_s > 0) {
        velocity_m_s += std::min(1.0, between_s / options.dt_s) * (moved_m / between_s - velocity_m_s);
        expected_s = std::min(between_s, options.safety.stale_s);
        same_position_s = 0;
        old_s = std::clamp(age_s, 0.0, options.dt_s);
    }
    const double speed = velocity_m_s.norm();
    if (!std::isfinite(speed))
        velocity_m_s.setZero();
    else if (speed > most)
        velocity_m_s *= most / speed;
}

void ToolState::no_contact(const Point& proxy_m) noexcept {
    contact = {};
    grasps = false;
    contact.proxy_m = proxy_m;
}

void ToolState::disarm(const Point& proxy_m) noexcept {
    forget_taken_over();
    no_contact(proxy_m);
    record.mesh = touched = -1;
    armed = false;
}

void ToolState::forget_taken_over() noexcept {
    carried = 0;
    carried_N.setZero();
    taken_over = false;
}

void ToolState::take_over(const ToolState& from, double period_s) noexcept {
    safety.go_on_from(from.safety);
    record.time_s = from.record.time_s;
    record.device_m = from.record.device_m;
    if (touched >= 0) {  // the contact has to slip by the hand's motion along the surface since follow()
        constexpr double far_m = 2e-4;
        const Point went = from.record.master_m - record.master_m, inward = spring.inward();
        carried = (went - went.dot(inward) * inward).norm() > far_m ? 1 : 0;
    }
    record.master_m = from.record.master_m;
    options.map = from.options.map;  // the clutch may have changed it since follow()
    options.device = from.options.device;
    options.safety = safety.options();
    device_m = from.device_m;
    has_master = from.has_master;
    clutched = from.clutched;
    velocity_m_s = from.velocity_m_s;
    expected_s = from.expected_s;
    same_position_s = from.same_position_s;
    old_s = from.old_s;
    stood_s = from.stood_s;
    unarmed = from.unarmed;
    grasp_asked = from.grasp_asked;
    record.grasp = from.record.grasp;
    let_go = from.let_go;
    contacts = from.contacts;
    at_m = at_the_end(record.master_m, period_s) - period_s * velocity_m_s;
    taken_over = true;
    friction.become(options.friction = from.options.friction);
    if (!from.armed) disarm(record.master_m);  // its contact was ended after follow()
}

void ToolState::show_no_more(bool on_energy_model) noexcept {
    spring.show_at_most(on_energy_model ? options.safety.force_max_N / options.map.force_scale : std::numeric_limits<double>::infinity());
}

}  // namespace tissue
