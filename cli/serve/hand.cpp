#include "hand.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tissue::serve {
namespace {

constexpr double clearance_m = 0.01;    ///< distance to the tissue at rest on the way; the tissue bulges by less
constexpr double travel_m_s = 0.5, approach_m_s = 0.08, press_m_s = 0.02, leave_m_s = 0.15;
// long enough for the tissue to come to rest and be compared before the tool leaves
constexpr double rest_s = 1.6, pause_s = 0.4;
constexpr double beside_m = 0.03;       ///< distance between parked tools
constexpr double settle_s = 0.15;       ///< the position of a device lags the hand
constexpr double reading_s = 2;         ///< a model that learns measures a hand that has been still for a while
constexpr double same_touch_m = 0.004;  ///< a client who indents deeper stays at the same contact
constexpr double inset_m = 0.0003;      ///< a tangential displacement must stay inside the surface

/// Step from one place of a tour to the next. All places are visited; if there are many, successive places are not
/// neighbours.
int stride(int count) {
    if (count <= 20) return 1;
    int step = static_cast<int>(0.382 * count);
    while (std::gcd(step, count) != 1) ++step;
    return step;
}

bool within(const Hand::Box& box, const Point& p, double margin) {
    return (p.array() > box.first.array() - margin).all() && (p.array() < box.second.array() + margin).all();
}

/// Whether the segment from a to b comes closer to a box than the margin.
bool hits(const Hand::Box& box, const Point& a, const Point& b, double margin) {
    double from = 0, to = 1;
    for (Eigen::Index axis = 0; axis < a.size(); ++axis) {
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

bool clear(const std::vector<Hand::Box>& boxes, const Point& a, const Point& b, double margin) {
    return std::none_of(boxes.begin(), boxes.end(), [&](const Hand::Box& box) { return hits(box, a, b, margin); });
}

/// Points where a path may turn: in the plane the corners of the boxes; in space the upper corners, and the points
/// above both ends.
std::vector<Point> turns(const std::vector<Hand::Box>& boxes, const Point& from, const Point& to, double clearance) {
    const Eigen::Index d = from.size(), up = d - 1;
    std::vector<Point> points;
    double top = -std::numeric_limits<double>::infinity();
    for (const Hand::Box& box : boxes) {
        top = std::max(top, box.second[up] + clearance);
        for (int corner = 0; corner < (1 << d); ++corner) {
            Point p(d);
            for (Eigen::Index axis = 0; axis < d; ++axis)
                p[axis] = corner >> axis & 1 ? box.second[axis] + clearance : box.first[axis] - clearance;
            if (d == 2 || p[up] > box.second[up]) points.push_back(p);
        }
    }
    for (const Point* end : {&from, &to}) {
        if (d == 2) break;
        points.push_back(*end);
        points.back()[up] = std::max(top, (*end)[up]);
    }
    return points;
}

}  // namespace

Point outside(const std::vector<Hand::Box>& boxes, const Point& p, double clearance) {
    const Eigen::Index up = p.size() - 1;
    Point out = p;
    for (const Hand::Box& box : boxes) {
        if (!within(box, out, clearance)) continue;
        Point nearest = out;
        double least = std::numeric_limits<double>::infinity();
        for (Eigen::Index axis = 0; axis <= up; ++axis)
            for (bool high : {false, true}) {
                // the lower side is fixed: leave by it only from below
                if (axis == up && !high && !(p[up] < box.first[up])) continue;
                const double side = high ? box.second[axis] + clearance : box.first[axis] - clearance, way = std::abs(side - out[axis]);
                if (!(way < least)) continue;
                least = way;
                nearest = out;
                nearest[axis] = side;
            }
        out = nearest;
    }
    return out;
}

std::vector<Point> way_round(const std::vector<Hand::Box>& boxes, const Point& from, const Point& to, double clearance) {
    const double margin = 0.9 * clearance;
    std::vector<Point> points = {from, to};
    for (const Point& p : turns(boxes, from, to, clearance)) points.push_back(p);
    // Dijkstra's algorithm over pairs of points with a clear segment
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
    std::vector<Point> way = {to};
    if (!std::isfinite(distance[1])) return way;
    for (std::size_t k = before[1]; k != 0; k = before[k]) way.insert(way.begin(), points[k]);
    return way;
}

Hand::Hand(const Scene& scene, int tool) : tool_(tool) {
    show(scene);
}

void Hand::show(const Scene& scene) {
    scene_ = &scene;
    mode_ = Mode::parked;
    way_.clear();
    inside_ = false;
    place_ = scene.first_place();
    touch_.resize(0);
    const auto& [low, high] = scene.boxes().front();
    at_ = 0.5 * (low + high);
    at_[at_.size() - 1] = high[at_.size() - 1] + 3 * clearance_m;
    at_[0] += tool_ * beside_m;
    entry_ = wanted_ = at_;
}

void Hand::follow(const Point& point_m) {
    // limit the distance to three times the extent of the tissue
    const auto& boxes = scene_->boxes();
    const Point size = boxes.back().second - boxes.front().first;
    wanted_ = point_m.cwiseMax(boxes.front().first - 3 * size).cwiseMin(boxes.back().second + 3 * size);
    const Eigen::Index up = wanted_.size() - 1;
    // not below the support
    if (scene_->dimension() == 3) wanted_[up] = std::max(wanted_[up], boxes.front().first[up]);
    if (mode_ != Mode::led) {
        // from an indentation of the demo, leave the tissue first
        way_.clear();
        inside_ = false;
        touch_.resize(0);
        mode_ = Mode::led;
    }
    if (inside_) return;
    if (scene_->dimension() == 3) return approach();
    come_in();
}

/// In the plane: to a point outside the nearest side, and from there straight to the client's position. In between the
/// hand waits until the device, which lags it, has arrived, because otherwise the tool would enter obliquely. It waits
/// once: while the client moves along the side, the hand follows along it, and then goes straight in.
void Hand::come_in() {
    const Point gate = outside(scene_->boxes(), wanted_, clearance_m);
    const bool coming = touch_.size() > 0 && !way_.empty();
    if (coming && (gate - touch_).norm() < same_touch_m) {   // already on its way there
        way_.back().to_m = wanted_;
        return;
    }
    if (coming && way_.size() == 1) return way_.clear();   // on its way in: counts as arrived
    const bool along = coming && clear(scene_->boxes(), at_, gate, 0.9 * clearance_m);
    const double wait_s = along ? way_[way_.size() - 2].wait_s : settle_s;
    way_.clear();
    go_round(gate);
    way_.back().wait_s = wait_s;
    touch_ = gate;
    way_.push_back({wanted_, approach_m_s});
}

/// In space: to the surface along its normal and on to the client's position; or directly to a point that is not at the
/// tissue.
void Hand::approach() {
    const Touch touch = scene_->nearest(wanted_);
    if (touch_.size() > 0 && (touch.contact_m - touch_).norm() < same_touch_m) {   // already on its way there
        way_.back().to_m = wanted_;
        return;
    }
    way_.clear();
    touch_.resize(0);
    const Point clear_of_all = outside(scene_->boxes(), touch.contact_m - 1.2 * clearance_m * touch.inward, clearance_m);
    if ((wanted_ - touch.contact_m).dot(touch.inward) < -clearance_m) return go_round(outside(scene_->boxes(), wanted_, clearance_m));
    go_round(clear_of_all);
    touch_ = touch.contact_m;
    way_.push_back({touch_, approach_m_s});
    way_.push_back({wanted_, approach_m_s});
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

/// Appends a path around the tissue from the end of the present path.
void Hand::go_round(const Point& to_m) {
    const auto& boxes = scene_->boxes();
    Point from = way_.empty() ? at_ : way_.back().to_m;
    const bool clear_here = std::none_of(boxes.begin(), boxes.end(), [&](const Box& b) { return within(b, from, 0.9 * clearance_m); });
    if (!clear_here) {
        from = outside(boxes, within(boxes.front(), from, 0) || within(boxes.back(), from, 0) ? entry_ : from, clearance_m);
        way_.push_back({from, travel_m_s});
    }
    for (const Point& p : way_round(boxes, from, to_m, clearance_m)) way_.push_back({p, travel_m_s});
}

/// Appends one indentation at the demo's place, and the way out.
void Hand::press() {
    const Place& place = scene_->places()[static_cast<std::size_t>(place_)];
    const double sink = scene_->model().is_energy_model() ? 1 : 1 + 1 / *scene_->model().options.coupling_ratio;
    const Point touch = place.contact_m + inset_m * place.inward;
    const Point away = outside(scene_->boxes(), place.contact_m - 1.2 * clearance_m * place.inward, clearance_m);
    go_round(away);
    way_.back().begins_press = true;
    way_.push_back({touch, approach_m_s});
    way_.push_back({touch + sink * place.depth_m * place.direction, press_m_s, scene_->learns() ? reading_s : rest_s});
    way_.push_back({touch, 2 * press_m_s});
    way_.push_back({away, leave_m_s, pause_s});
}

Point Hand::step(double elapsed_s) {
    double left = elapsed_s;
    begins_press_ = false;
    while (left > 0 && !way_.empty()) {
        Leg& leg = way_.front();
        const double distance = (leg.to_m - at_).norm(), needed = distance / leg.speed_m_s;
        if (needed > left) {
            at_ += (leg.to_m - at_) * (left / needed);
            break;
        }
        left -= needed;
        at_ = leg.to_m;
        begins_press_ = begins_press_ || leg.begins_press;
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
