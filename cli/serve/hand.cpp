#include "hand.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tissue::serve {
namespace {

constexpr double clearance_m = 0.01;    ///< kept from the tissue at rest while on the way; it bulges by less
constexpr double travel_m_s = 0.5, approach_m_s = 0.08, press_m_s = 0.02, leave_m_s = 0.15;
constexpr double rest_s = 0.8, pause_s = 0.4;
constexpr double inset_m = 0.0003;      ///< a push along the surface must stay inside it

/// From one place of a tour to the next: all are visited, and of many, neighbours not one after the other.
int stride(int count) {
    if (count <= 20) return 1;
    int step = static_cast<int>(0.382 * count);
    while (std::gcd(step, count) != 1) ++step;
    return step;
}

bool within(const Hand::Box& box, const Eigen::Vector2d& p, double margin) {
    return (p.array() > box.first.array() - margin).all() && (p.array() < box.second.array() + margin).all();
}

/// Whether the way from a to b comes closer to a box than this.
bool hits(const Hand::Box& box, const Eigen::Vector2d& a, const Eigen::Vector2d& b, double margin) {
    double from = 0, to = 1;
    for (int axis : {0, 1}) {
        const double low = box.first[axis] - margin, high = box.second[axis] + margin, d = b[axis] - a[axis];
        if (std::abs(d) < 1e-12) {
            if (a[axis] <= low || a[axis] >= high) return false;
            continue;
        }
        const double t0 = (low - a[axis]) / d, t1 = (high - a[axis]) / d;
        from = std::max(from, std::min(t0, t1));
        to = std::min(to, std::max(t0, t1));
    }
    return from < to;
}

bool clear(const std::vector<Hand::Box>& boxes, const Eigen::Vector2d& a, const Eigen::Vector2d& b, double margin) {
    return std::none_of(boxes.begin(), boxes.end(), [&](const Hand::Box& box) { return hits(box, a, b, margin); });
}

}  // namespace

Eigen::Vector2d outside(const std::vector<Hand::Box>& boxes, const Eigen::Vector2d& p, double clearance) {
    Eigen::Vector2d out = p;
    for (const Hand::Box& box : boxes) {
        if (!within(box, out, clearance)) continue;
        const Eigen::Vector2d low = box.first.array() - clearance, high = box.second.array() + clearance;
        const Eigen::Vector2d sides[] = {{low.x(), out.y()}, {high.x(), out.y()}, {out.x(), high.y()}, {out.x(), low.y()}};
        // the lower side is the held one: only from outside
        const int count = p.y() < box.first.y() ? 4 : 3;
        out = *std::min_element(sides, sides + count, [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
            return (a - out).norm() < (b - out).norm();
        });
    }
    return out;
}

std::vector<Eigen::Vector2d> way_round(const std::vector<Hand::Box>& boxes, const Eigen::Vector2d& from,
                                       const Eigen::Vector2d& to, double clearance) {
    const double margin = 0.9 * clearance;
    std::vector<Eigen::Vector2d> points = {from, to};
    for (const Hand::Box& box : boxes) {
        const Eigen::Vector2d low = box.first.array() - clearance, high = box.second.array() + clearance;
        for (const Eigen::Vector2d& p : {low, Eigen::Vector2d(high.x(), low.y()), high, Eigen::Vector2d(low.x(), high.y())})
            points.push_back(p);
    }
    // Dijkstra over what sees each other
    const std::size_t n = points.size();
    std::vector<double> distance(n, std::numeric_limits<double>::infinity());
    std::vector<std::size_t> before(n, 0);
    std::vector<bool> done(n, false);
    distance[0] = 0;
    for (std::size_t round = 0; round < n; ++round) {
        std::size_t k = n;
        for (std::size_t i = 0; i < n; ++i)
            if (!done[i] && std::isfinite(distance[i]) && (k == n || distance[i] < distance[k])) k = i;
        if (k == n) break;
        done[k] = true;
        for (std::size_t i = 0; i < n; ++i) {
            const double reach = distance[k] + (points[i] - points[k]).norm();
            if (!done[i] && reach < distance[i] && clear(boxes, points[k], points[i], margin)) {
                distance[i] = reach;
                before[i] = k;
            }
        }
    }
    std::vector<Eigen::Vector2d> way = {to};
    if (!std::isfinite(distance[1])) return way;
    for (std::size_t k = before[1]; k != 0; k = before[k]) way.insert(way.begin(), points[k]);
    return way;
}

Hand::Hand(const Scene& scene) {
    show(scene);
}

void Hand::show(const Scene& scene) {
    scene_ = &scene;
    mode_ = Mode::parked;
    way_.clear();
    inside_ = false;
    place_ = scene.first_place();
    const auto& [low, high] = scene.boxes().front();
    at_ = entry_ = wanted_ = {0.5 * (low.x() + high.x()), high.y() + 3 * clearance_m};
}

void Hand::follow(const Eigen::Vector2d& point_m) {
    // nothing is farther away than three times what there is to touch
    const auto& boxes = scene_->boxes();
    const Eigen::Vector2d size = boxes.back().second - boxes.front().first;
    wanted_ = point_m.cwiseMax(boxes.front().first - 3 * size).cwiseMin(boxes.back().second + 3 * size);
    if (mode_ != Mode::led) {
        // from the demo's press first out of the tissue again
        way_.clear();
        inside_ = false;
        mode_ = Mode::led;
    }
    if (inside_) return;
    way_.clear();
    go_round(outside(boxes, wanted_, clearance_m));
}

void Hand::let_go() {
    if (mode_ == Mode::parked) return;
    mode_ = Mode::parked;
    inside_ = false;
    way_.clear();
    way_.push_back({outside(scene_->boxes(), entry_, clearance_m), travel_m_s});
}

void Hand::demonstrate(int place) {
    const int count = static_cast<int>(scene_->places().size());
    if (count == 0) return;
    if (mode_ != Mode::parked) let_go();
    mode_ = Mode::demo;
    tour_ = place < 0;
    place_ = place >= 0 && place < count ? place : scene_->first_place();
    press();
}

/// Adds the way round the tissue from where the hand will be then.
void Hand::go_round(const Eigen::Vector2d& to_m) {
    const auto& boxes = scene_->boxes();
    Eigen::Vector2d from = way_.empty() ? at_ : way_.back().to_m;
    const bool clear_here = std::none_of(boxes.begin(), boxes.end(), [&](const Box& b) { return within(b, from, 0.9 * clearance_m); });
    if (!clear_here) {
        from = outside(boxes, within(boxes.front(), from, 0) || within(boxes.back(), from, 0) ? entry_ : from, clearance_m);
        way_.push_back({from, travel_m_s});
    }
    for (const Eigen::Vector2d& p : way_round(boxes, from, to_m, clearance_m)) way_.push_back({p, travel_m_s});
}

/// Adds one press at the demo's place, and back out.
void Hand::press() {
    const Place& place = scene_->places()[static_cast<std::size_t>(place_)];
    const double sink = scene_->model().is_law() ? 1 : 1 + 1 / scene_->model().options.coupling_ratio;
    const Eigen::Vector2d touch = place.contact_m + inset_m * place.inward;
    const Eigen::Vector2d away = outside(scene_->boxes(), place.contact_m - 1.2 * clearance_m * place.inward, clearance_m);
    go_round(away);
    way_.push_back({touch, approach_m_s});
    way_.push_back({touch + sink * place.depth_m * place.direction, press_m_s, rest_s});
    way_.push_back({touch, 2 * press_m_s});
    way_.push_back({away, leave_m_s, pause_s});
}

Eigen::Vector2d Hand::step(double elapsed_s) {
    double left = elapsed_s;
    while (left > 0 && !way_.empty()) {
        Leg& leg = way_.front();
        const double distance = (leg.to_m - at_).norm(), needed = distance / leg.speed_m_s;
        if (needed > left) {
            at_ += (leg.to_m - at_) * (left / needed);
            break;
        }
        left -= needed;
        at_ = leg.to_m;
        remember_way_out();
        if (leg.wait_s > left) {
            leg.wait_s -= left;
            break;
        }
        left -= leg.wait_s;
        way_.pop_front();
    }
    if (mode_ == Mode::led && way_.empty()) {
        inside_ = true;
        at_ = wanted_;
    }
    if (mode_ == Mode::demo && way_.empty()) {
        const int count = static_cast<int>(scene_->places().size());
        if (tour_) place_ = (place_ + stride(count)) % count;
        press();
    }
    remember_way_out();
    return at_;
}

void Hand::remember_way_out() {
    const auto& boxes = scene_->boxes();
    if (std::none_of(boxes.begin(), boxes.end(), [&](const Box& b) { return within(b, at_, 0); })) entry_ = at_;
}

}  // namespace tissue::serve
