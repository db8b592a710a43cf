#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <string>
#include <vector>

#include "haptic/simulation.h"

namespace tissue::test {

/// Device and hand as one mass, with a damper to the ground and a spring to the place where it began to move freely.
struct Hand {
    const char* name;
    double mass_kg, damping_Ns_m, stiffness_N_m;
};

constexpr Hand hands[] = {
    {"45 g alone", 0.045, 0.2, 0},  // a Touch without a hand
    {"100 g", 0.1, 1, 0},
    {"150 g", 0.15, 3, 300},
    {"200 g", 0.2, 6, 500},
};

/// Timing of the ticks: the period and its random variation.
struct Clock {
    const char* name;
    double jitter_s, late_share;  ///< a late tick comes one to three periods late
    double age_s = 0;             ///< age of a position when it is used
};

constexpr Clock clocks[] = {{"on time", 0, 0}, {"jitter 0.3 ms", 3e-4, 0}, {"2 % late", 0, 0.02}};

/// A hand that is led along straight lines whatever the force, and its work [J].
struct Led {
    Simulation simulation;
    Eigen::Vector3d at, force_N = Eigen::Vector3d::Zero();
    double work_J = 0, period_s;
    bool grasp = false;

    Led(const HapticModel& model, const Eigen::Vector3d& from, double period = 1e-3) : simulation(model), at(from), period_s(period) { tick(from); }
    void tick(const Eigen::Vector3d& to) {
        work_J -= force_N.dot(to - at);
        at = to;
        DeviceSample sample;
        sample.position_m = to;
        sample.grasp = grasp;
        force_N = simulation.tick(sample, period_s);
    }
    void lead(const Eigen::Vector3d& to, double speed_m_s = 0.02) {
        const Eigen::Vector3d from = at;
        const int count = static_cast<int>(std::ceil((to - from).norm() / speed_m_s / period_s));
        for (int k = 1; k <= count; ++k) tick(from + static_cast<double>(k) / count * (to - from));
    }
    void wait(double seconds) {
        for (long left = std::lround(seconds / period_s); left > 0; --left) tick(at);
    }
};

/// A hand that moves freely under a constant force from a contact on.
struct Release {
    Point contact_m, inward;   ///< place, and unit vector into the tissue, along which the force acts
    double force_N = 1;
    double seconds = 3.2;
    bool creeps = false;       ///< the tissue relaxes
    double drag_m = 0.02;      ///< length of a drag
    double inset_m = 5e-4;     ///< depth to which the hand is led first
};

struct Rest {
    double swing_m = 0;        ///< largest extent of the hand's path in a quarter of a second, after 2 s
    /// swing_m of the same hand on a spring without losses that has the tissue's secant stiffness, scaled to the same
    /// extent in the first second; 0 where the tool ends outside the tissue
    double damped_m = 0;
    double swing_N = 0;        ///< the same of the force on the hand
    double force_N = 0;        ///< force of the hand at the end
    double controlled = 0;     ///< share of ticks in which the passivity controller acted
    /// at the end: contact at rest, tool displacement there, and force of the tool on the tissue
    Point touched_m, push_m, tissue_N;
    bool contact = false;      ///< at the end
    int faults = 0;
};

struct Moment {
    double time_s;
    Eigen::Vector3d position_m, force_N;
};

/// Diagonal of the bounding box of a quantity. Where the tissue creeps, of its deviation from a straight line in time.
template <class Of>
double extent(const std::vector<Moment>& way, bool creeps, const Of& of) {
    const Moment &first = way.front(), &last = way.back();
    const Eigen::Vector3d rate = creeps ? Eigen::Vector3d((of(last) - of(first)) / (last.time_s - first.time_s)) : Eigen::Vector3d(Eigen::Vector3d::Zero());
    Eigen::Vector3d low = of(first), high = low;
    for (const Moment& m : way) {
        const Eigen::Vector3d at = of(m) - rate * (m.time_s - first.time_s);
        low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
    return (high - low).norm();
}

/// A hand on the tissue, with twenty integration steps per tick. The force is constant between two ticks, as a device
/// holds it.
class HandLoop {
   public:
    HandLoop(const HapticModel& model, const Hand& hand, const Clock& clock) : simulation(model), hand_(hand), clock_(clock) {}

    /// Moves the hand on a straight line, independent of the force.
    void lead(const Point& from_m, const Point& to_m, double seconds) {
        const double dt = simulation.model().options.dt_s;
        const int count = static_cast<int>(seconds / dt);
        for (int k = 0; k <= count; ++k) {
            const Eigen::Vector3d before = x;
            x = simulation.model().options.map.to_device(from_m + static_cast<double>(k) / count * (to_m - from_m));
            if (k > 0) book(force.dot(x - before));
            tick(dt);
        }
        v.setZero();
    }

    /// applied(time, x, v): force on the hand besides that of the tissue [N]. each(*this): called after every tick.
    template <class Applied, class Each>
    void play(double seconds, const Applied& applied, const Each& each) {
        constexpr int steps = 20;
        const double end = time + seconds, dt = simulation.model().options.dt_s;
        while (time < end) {
            double until = dt;
            if (clock_.jitter_s > 0) {
                const double next = clock_.jitter_s * (2 * uniform() - 1);
                until = dt + next - offset_;
                offset_ = next;
            }
            if (clock_.late_share > 0 && uniform() < clock_.late_share) until += dt * (1 + std::floor(3 * uniform()));
            const double h = until / steps;
            for (int k = 0; k < steps; ++k) {
                v = (v + h * (applied(time + k * h, x, v) + force) / hand_.mass_kg) / (1 + h * hand_.damping_Ns_m / hand_.mass_kg);
                x += h * v;
                way_.emplace_back(now_s_ + (k + 1) * h, x);
                book(h * force.dot(v));
            }
            time += until;
            tick(until);
            each(*this);
        }
    }

    double controlled(long long damped_before, long long ticks_before) const {
        return static_cast<double>(simulation.safety().counters().damped - damped_before) / static_cast<double>(std::max(1LL, ticks - ticks_before));
    }
    long long damped() const { return simulation.safety().counters().damped; }

    Simulation simulation;
    Eigen::Vector3d x = Eigen::Vector3d::Zero(), v = x, force = x;
    double time = 0;                                     ///< in play()
    /// energy given to hand and device, by the true motion; its largest value; the largest energy put in
    double given_J = 0, most_given_J = 0, put_in_J = 0;
    long long ticks = 0;
    int faults = 0;

   private:
    void tick(double seconds) {
        DeviceSample sample;
        now_s_ += seconds;
        way_.emplace_back(now_s_, x);
        while (way_.size() > 1 && way_[1].first <= now_s_ - clock_.age_s + 1e-9) way_.pop_front();
        sample.position_m = way_.front().second;
        sample.age_s = clock_.age_s;
        force = simulation.tick(sample, seconds);
        faults += simulation.record().fault();
        ++ticks;
    }
    void book(double joule) {
        given_J += joule;
        most_given_J = std::max(most_given_J, given_J);
        put_in_J = std::max(put_in_J, -given_J);
    }
    double uniform() { return static_cast<double>(random_() >> 11) * 0x1.0p-53; }

    Hand hand_;
    Clock clock_;
    std::mt19937_64 random_{2008};
    double offset_ = 0, now_s_ = 0;
    std::deque<std::pair<double, Eigen::Vector3d>> way_;  ///< path of the hand, as far back as positions are old
};

/// Times of let_go: the force rises for ramp_s. The first second is measured then, and after wait_s windows of
/// window_s.
constexpr double ramp_s = 0.2, first_s = 1, wait_s = 2, window_s = 0.25;

/// Extent that let_go would measure after wait_s, over that of the first second, on a spring without losses that begins
/// at the hand's first place.
inline double left_by_damping(const Hand& hand, double spring_N_m, double seconds) {
    constexpr double h = 1e-4;
    const auto along = [](double x) { return Moment{0, {x, 0, 0}, {0, 0, 0}}; };
    const auto extent_of = [](const std::vector<Moment>& way) { return extent(way, false, [](const Moment& m) { return m.position_m; }); };
    std::vector<Moment> first, last;
    double x = 0, v = 0, most = 0;
    for (double t = 0; t < seconds; t += h) {
        v = (v + h * (std::min(1.0, t / ramp_s) - (spring_N_m + hand.stiffness_N_m) * x) / hand.mass_kg) / (1 + h * hand.damping_Ns_m / hand.mass_kg);
        x += h * v;
        if (t > ramp_s && t <= ramp_s + first_s) first.push_back(along(x));
        if (t <= ramp_s + wait_s) continue;
        last.push_back(along(x));
        if (static_cast<double>(last.size()) * h < window_s) continue;
        most = std::max(most, extent_of(last));
        last.clear();
    }
    return most / extent_of(first);
}

/// A hand that is led to just inside the surface, then moves freely under the force and comes to rest.
inline Rest let_go(const HapticModel& model, const Hand& hand, const Clock& clock, const Release& release) {
    bool first_way = true;
    double first_m = 0;
    HandLoop loop(model, hand, clock);
    const Eigen::Vector3d push = model.options.map.force_from_tissue(release.force_N * release.inward);
    loop.lead(release.contact_m - 0.003 * release.inward, release.contact_m + release.inset_m * release.inward, 0.3);
    const Eigen::Vector3d anchor = loop.x;
    const long long damped = loop.damped(), ticks = loop.ticks;
    const int faults = loop.faults;
    Rest rest;
    std::vector<Moment> way;
    loop.play(
        release.seconds, [&](double time, const Eigen::Vector3d& x, const Eigen::Vector3d&) { return Eigen::Vector3d(std::min(1.0, time / ramp_s) * push - hand.stiffness_N_m * (x - anchor)); },
        [&](const HandLoop& now) {
            const bool first = now.time > ramp_s && now.time <= ramp_s + first_s, last = now.time > ramp_s + wait_s;
            if (!first && !last) return;
            if (last && first_way) {
                first_m = extent(way, release.creeps, [](const Moment& m) { return m.position_m; });
                way.clear();
                first_way = false;
            }
            way.push_back({now.time, now.x, now.force});
            if (first || now.time - way.front().time_s < window_s) return;
            rest.swing_m = std::max(rest.swing_m, extent(way, release.creeps, [](const Moment& m) { return m.position_m; }));
            rest.swing_N = std::max(rest.swing_N, extent(way, release.creeps, [](const Moment& m) { return m.force_N; }));
            way.clear();
        });
    const Simulation& s = loop.simulation;
    rest.faults = loop.faults - faults;
    rest.force_N = (push - hand.stiffness_N_m * (loop.x - anchor)).norm();
    const double depth_m = model.options.map.force_to_tissue(loop.x - model.options.map.to_device(release.contact_m)).dot(release.inward);
    if (s.contact().pressing && depth_m > 0) rest.damped_m = left_by_damping(hand, loop.force.norm() / depth_m, release.seconds) * first_m;
    rest.controlled = loop.controlled(damped, ticks);
    rest.contact = s.contact().pressing;
    if (s.record().mesh == 0) rest.touched_m = model.meshes[0]->springs.rest_place(s.record().facet, s.record().weight);
    rest.push_m = s.record().contact_displacement_m;
    rest.tissue_N = -s.record().coupling_N;
    return rest;
}

/// Energy and motion of a hand during an action.
struct Ride {
    double most_given_J = 0, put_in_J = 0;  ///< energy given to the hand, and energy put in by the hand
    /// largest extent of the hand's path in a fiftieth of a second, as deviation from a straight line, after 1.5 s; of
    /// a hand that drags, while it is on the tissue
    double tremor_m = 0;
    double controlled = 0;
    int faults = 0;
    bool contact = false;                   ///< at the end
    bool lost = false;                      ///< whether a dragging hand lost contact

    /// The hand got at most 1 % of the energy that it put in, and a microjoule. A late tick may give that much.
    bool passive() const { return most_given_J <= 1e-6 + 0.01 * put_in_J; }
};

enum class Deed { taps, lets_go, drags };

/// An action on tissue at rest.
/// taps: moves in from outside at 0.3 m/s. A grip, for hands with a stiffness, pulls it to 3 mm inside the surface.
/// lets_go: is led onto the surface, presses with the force for 1.5 s, then without any force.
/// drags: is led onto the surface and presses with the force. After a second it is led along the surface by
/// release.drag_m, back, and by half of that again.
inline Ride does(Deed deed, const HapticModel& model, const Hand& hand, const Clock& clock, const Release& release) {
    HandLoop loop(model, hand, clock);
    const DeviceMap& map = model.options.map;
    const auto in_device = [&](const Point& direction) { return Eigen::Vector3d(map.force_from_tissue(direction)); };
    const Eigen::Vector3d inward = in_device(release.inward);
    Point across = Point::Zero(release.inward.size());
    across[0] = release.inward[across.size() - 1], across[across.size() - 1] = -release.inward[0];
    const Eigen::Vector3d along = in_device(across.normalized());
    const Point start_m = release.contact_m - 0.006 * release.inward;
    loop.lead(start_m, start_m, 0.02);
    const Eigen::Vector3d held = map.to_device(release.contact_m + 0.003 * release.inward);
    if (deed == Deed::taps) loop.v = 0.3 * inward;
    else loop.lead(start_m, release.contact_m + release.inset_m * release.inward, 0.3);
    Ride ride;
    std::vector<Moment> way;
    const auto play = [&](double seconds, auto&& applied) {
        loop.play(seconds, applied, [&](const HandLoop& now) {
            const bool away = deed == Deed::drags && !now.simulation.contact().pressing;
            if (away && now.time > 1) ride.lost = true;
            if (away) way.clear();
            if (away || now.time <= 1.5) return;
            way.push_back({now.time, now.x, now.force});
            if (now.time - way.front().time_s < 0.02) return;
            ride.tremor_m = std::max(ride.tremor_m, extent(way, true, [](const Moment& m) { return m.position_m; }));
            way.clear();
        });
    };
    const auto grip = [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(-hand.stiffness_N_m * (x - held)); };
    const auto pressed = [&](double time, const Eigen::Vector3d& x, const Eigen::Vector3d& v) {
        // a damper while the force rises, so that the hand is at rest afterwards
        const Eigen::Vector3d brake = time < 0.5 ? Eigen::Vector3d(-6 * v) : Eigen::Vector3d::Zero().eval();
        return Eigen::Vector3d(std::min(1.0, time / 0.3) * release.force_N * inward + brake + (hand.stiffness_N_m > 0 ? 0 : -100) * (x - held).dot(along) * along);
    };
    if (deed == Deed::taps) play(1.5, [&](double, const Eigen::Vector3d& x, const Eigen::Vector3d&) { return grip(x); });
    if (deed == Deed::lets_go) {
        play(1.5, pressed);
        play(1.0, [&](double, const Eigen::Vector3d&, const Eigen::Vector3d&) { return Eigen::Vector3d::Zero().eval(); });
    }
    if (deed == Deed::drags)
        play(3.5, [&](double time, const Eigen::Vector3d& x, const Eigen::Vector3d& v) {
            const double since = std::max(0.0, time - 1), at = release.drag_m / 2 * (1 - std::cos(3.14159 * since)), speed = 1.57 * release.drag_m * std::sin(3.14159 * since);
            const Eigen::Vector3d led = 300 * (at - (x - held).dot(along)) * along + 6 * (speed - v.dot(along)) * along;
            const Eigen::Vector3d brake = time < 0.5 ? Eigen::Vector3d(-6 * v) : Eigen::Vector3d::Zero().eval();
            return Eigen::Vector3d(std::min(1.0, time / 0.3) * release.force_N * inward + brake + led);
        });
    ride.most_given_J = loop.most_given_J;
    ride.put_in_J = loop.put_in_J;
    ride.controlled = loop.controlled(0, 0);
    ride.faults = loop.faults;
    ride.contact = loop.simulation.contact().pressing;
    return ride;
}

}  // namespace tissue::test
