#include "haptic/selector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "error.h"
#include "springs/equilibrium.h"

namespace tissue {
namespace {

constexpr double same_m = 1e-9, same_radians = 1e-6, turn = 2 * 3.14159265358979323846;

/// Into [0, turn).
double wrapped(double radians) noexcept {
    const double r = std::fmod(radians, turn);
    return r < 0 ? r + turn : r;
}

/// How far a push is from `from` to `to` on a linear scale, in [0, 1].
double share_between(double value, double from, double to) noexcept {
    return to > from ? std::clamp((value - from) / (to - from), 0.0, 1.0) : 0.0;
}

}  // namespace

Selector::Selector(const TissueModel& model, const Eigen::Ref<const NodeField>& theta, const SelectorOptions& options)
    : options_(options) {
    const SpringMesh& mesh = model.mesh;
    const std::size_t M = mesh.boundary.size();
    along_m_.push_back(0);
    for (std::size_t b = 0; b < M; ++b) {
        const Eigen::Vector2d start = mesh.nodes.row(mesh.boundary[b]), end = mesh.nodes.row(mesh.boundary[(b + 1) % M]);
        outline_m_.push_back(start);
        normal_.push_back(Eigen::Vector2d(-(end - start).y(), (end - start).x()).normalized());
        along_m_.push_back(along_m_.back() + (end - start).norm());
    }

    const auto law = make_spring_law(model.law);
    double smallest = std::numeric_limits<double>::infinity();
    for (int c = 0; c < model.case_count(); ++c) {
        const Eigen::Vector2d position = model.contact_m.row(c), direction = model.direction.row(c);
        const SurfacePoint point = locate_on_surface(mesh, position);
        Eigen::Vector2d push = direction * model.magnitude_m[c];
        if (options_.by == SelectorOptions::By::force) {
            std::string reason;
            const auto rest = solve_equilibrium(mesh, *law, theta.row(c).transpose(), point, push, reason);
            if (!rest)
                throw MismatchError(fmt::format("set '{}' cannot be selected by force: {}",
                                                model.case_names[static_cast<std::size_t>(c)], reason));
            push = rest->contact_force;
        }
        smallest = std::min(smallest, push.norm());

        const std::size_t b = static_cast<std::size_t>(
            std::find(mesh.boundary.begin(), mesh.boundary.end(), point.node[0]) - mesh.boundary.begin());
        double along = along_m_[b] + point.weight[1] * (along_m_[b + 1] - along_m_[b]);
        if (along > along_m_.back() - same_m) along = 0;
        auto contact = std::find_if(contacts_.begin(), contacts_.end(),
                                    [&](const Contact& k) { return std::abs(k.along_m - along) < same_m; });
        if (contact == contacts_.end()) contact = contacts_.insert(contacts_.end(), Contact{position, along, {}});
        // by displacement the case's own direction and magnitude; by force what the set answers to it. Sets of one
        // direction belong together either way
        const double radians = wrapped(std::atan2(push.y(), push.x()));
        const double same = options_.by == SelectorOptions::By::force ? 0.1 : same_radians;
        auto angle = std::find_if(contact->angles.begin(), contact->angles.end(), [&](const Angle& a) {
            return std::abs(std::remainder(a.radians - radians, turn)) < same;
        });
        if (angle == contact->angles.end()) angle = contact->angles.insert(contact->angles.end(), Angle{radians, {}});
        angle->magnitudes.push_back({push.norm(), c});
    }
    if (contacts_.empty()) throw MismatchError("the model has no spring sets");
    small_ = 0.01 * smallest;
    std::sort(contacts_.begin(), contacts_.end(), [](const Contact& a, const Contact& b) { return a.along_m < b.along_m; });
    for (Contact& contact : contacts_) {
        std::sort(contact.angles.begin(), contact.angles.end(),
                  [](const Angle& a, const Angle& b) { return a.radians < b.radians; });
        for (Angle& angle : contact.angles)
            std::sort(angle.magnitudes.begin(), angle.magnitudes.end(),
                      [](const Magnitude& a, const Magnitude& b) { return a.size < b.size; });
    }
}

SetWeights Selector::select(int segment, double w, const Eigen::Vector2d& push) const noexcept {
    const auto b = static_cast<std::size_t>(segment);
    const Eigen::Vector2d directed = push + small_ * normal_[b];
    SetWeights out;
    if (options_.mode == SelectorOptions::Mode::nearest) {
        const Eigen::Vector2d position =
            (1 - w) * outline_m_[b] + w * outline_m_[(b + 1) % outline_m_.size()];
        const Contact* best = &contacts_.front();
        for (const Contact& contact : contacts_)
            if ((contact.position_m - position).squaredNorm() < (best->position_m - position).squaredNorm()) best = &contact;
        add(*best, 1, directed, out);
        return out;
    }
    const double whole = along_m_.back(), along = along_m_[b] + w * (along_m_[b + 1] - along_m_[b]);
    const auto after = std::upper_bound(contacts_.begin(), contacts_.end(), along,
                                        [](double value, const Contact& c) { return value < c.along_m; });
    const Contact& next = after == contacts_.end() ? contacts_.front() : *after;
    const Contact& last = after == contacts_.begin() ? contacts_.back() : *(after - 1);
    if (&next == &last) {
        add(last, 1, directed, out);
        return out;
    }
    const double from = last.along_m > along ? last.along_m - whole : last.along_m;
    const double to = next.along_m <= along ? next.along_m + whole : next.along_m;
    const double share = share_between(along, from, to);
    add(last, 1 - share, directed, out);
    add(next, share, directed, out);
    return out;
}

void Selector::add(const Contact& contact, double share, const Eigen::Vector2d& push, SetWeights& out) const noexcept {
    if (!(share > 0)) return;
    const double size = push.norm(), radians = wrapped(std::atan2(push.y(), push.x()));
    const std::vector<Angle>& angles = contact.angles;
    if (angles.size() == 1) return add(angles.front(), share, size, out);
    const auto after = std::upper_bound(angles.begin(), angles.end(), radians,
                                        [](double value, const Angle& a) { return value < a.radians; });
    const Angle& next = after == angles.end() ? angles.front() : *after;
    const Angle& last = after == angles.begin() ? angles.back() : *(after - 1);
    const double gap = wrapped(next.radians - last.radians), past = wrapped(radians - last.radians);
    double part = share_between(past, 0, gap);
    if (gap > turn / 2) part = share_between(past, gap / 2 - turn / 8, gap / 2 + turn / 8);
    if (options_.mode == SelectorOptions::Mode::nearest) part = past <= gap - past ? 0 : 1;
    if (part < 1) add(last, share * (1 - part), size, out);
    if (part > 0) add(next, share * part, size, out);
}

void Selector::add(const Angle& angle, double share, double size, SetWeights& out) const noexcept {
    const std::vector<Magnitude>& magnitudes = angle.magnitudes;
    const auto after = std::upper_bound(magnitudes.begin(), magnitudes.end(), size,
                                        [](double value, const Magnitude& m) { return value < m.size; });
    const Magnitude& next = after == magnitudes.end() ? magnitudes.back() : *after;
    const Magnitude& last = after == magnitudes.begin() ? magnitudes.front() : *(after - 1);
    double part = share_between(size, last.size, next.size);
    if (options_.mode == SelectorOptions::Mode::nearest) part = part <= 0.5 ? 0 : 1;
    for (const auto& [set, weight] : {std::pair(last.set, share * (1 - part)), std::pair(next.set, share * part)})
        if (weight > 0 && out.count < SetWeights::most) {
            out.set[out.count] = set;
            out.weight[out.count++] = weight;
        }
}

}  // namespace tissue
