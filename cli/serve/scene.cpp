#include "scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "mesh/outline.h"

namespace tissue::serve {
namespace {

using Json = nlohmann::ordered_json;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

Json pair(const Eigen::Vector2d& v) {
    return Json::array({v.x(), v.y()});
}

/// "left-10mm" -> "left": what the cases of one place have in common.
std::string without_depth(const std::string& name) {
    const std::size_t dash = name.rfind('-');
    const bool depth = dash != std::string::npos && name.size() > dash + 2 && name.compare(name.size() - 2, 2, "mm") == 0;
    return depth ? name.substr(0, dash) : name;
}

/// Where the contact is on the learned mesh at rest.
Eigen::Vector2d contact_at_rest(const TickRecord& record, const HapticModel& model) {
    return model.meshes[0]->springs.rest_place(record.facet, record.weight);
}

double at_depth(const std::vector<std::pair<double, double>>& curve, double depth_m) {
    if (depth_m < 0) return unknown;
    for (std::size_t k = 1; k < curve.size(); ++k) {
        const auto &a = curve[k - 1], &b = curve[k];
        if (depth_m <= b.first) return a.second + (b.second - a.second) * (depth_m - a.first) / (b.first - a.first);
    }
    return unknown;
}

}  // namespace

Scene::Scene(const TissueModel& tissue, const HapticModel& model, const std::vector<NodeField>& fe_displacement_m)
    : model_(model), fixed_(tissue.mesh.fixed), springs_(tissue.mesh.springs) {
    for (const auto& mesh : model.meshes) boxes_.emplace_back(Eigen::Vector2d(mesh->place_m + model.low_m), Eigen::Vector2d(mesh->place_m + model.high_m));
    const Outline outline(tissue.mesh);
    const std::vector<int>& nodes = model.meshes[0]->springs.outline();
    const bool forces = tissue.contact_force_N.rows() > 0;
    for (int c = 0; c < tissue.case_count(); ++c) {
        const Eigen::Vector2d contact = tissue.contact_m.row(c), direction = tissue.direction.row(c);
        std::size_t k = 0;
        while (k < places_.size() && ((places_[k].contact_m - contact).norm() > 1e-9 || (places_[k].direction - direction).norm() > 1e-9))
            ++k;
        if (k == places_.size())
            places_.push_back({without_depth(tissue.case_names[static_cast<std::size_t>(c)]), contact, direction,
                               outline.inward_normal(outline.arc_of(contact)), 0, {}, {}});
        Place& place = places_[k];
        place.depth_m = std::max(place.depth_m, tissue.magnitude_m[c]);
        if (forces) place.curve.emplace_back(tissue.magnitude_m[c], tissue.contact_force_N.row(c).dot(direction));
        if (!fe_displacement_m.empty())
            place.outlines.push_back(
                {tissue.magnitude_m[c], fe_displacement_m[static_cast<std::size_t>(c)](nodes, Eigen::all)});
    }
    for (Place& place : places_) {
        if (!place.outlines.empty())
            place.outlines.push_back({0, NodeField::Zero(static_cast<Eigen::Index>(nodes.size()), 2)});
        std::sort(place.outlines.begin(), place.outlines.end(),
                  [](const FeOutline& a, const FeOutline& b) { return a.depth_m < b.depth_m; });
        if (place.curve.empty()) continue;
        place.curve.emplace_back(0, 0);
        std::sort(place.curve.begin(), place.curve.end());
    }
    const Eigen::Vector2d top(0.5 * (model.low_m.x() + model.high_m.x()), model.high_m.y());
    const double width = model.high_m.x() - model.low_m.x();
    double best = -1e9;
    for (std::size_t k = 0; k < places_.size(); ++k) {
        const double merit = places_[k].direction.dot(places_[k].inward) - (places_[k].contact_m - top).norm() / width;
        if (merit > best) best = merit, first_ = static_cast<int>(k);
    }
}

Near Scene::near(const TickState& state) const {
    Near near{-1, 0, unknown};
    if (state.record.mesh < 0) return near;
    const Eigen::Vector2d contact = contact_at_rest(state.record, model_);
    const Eigen::Vector2d push = state.contact_displacement_m[0];
    double best = 1e9, best_along = -1e9;
    for (std::size_t k = 0; k < places_.size(); ++k) {
        const double distance = (places_[k].contact_m - contact).norm(), along = places_[k].direction.dot(push);
        const bool nearer = distance < best - 1e-9, same = distance < best + 1e-9;
        if (!nearer && !(same && along > best_along)) continue;
        best = distance;
        best_along = along;
        near = {static_cast<int>(k), distance, at_depth(places_[k].curve, along)};
    }
    return near;
}

std::string Scene::message(const std::vector<std::string>& names, int index) const {
    const HapticOptions& o = model_.options;
    Json j = {{"type", "model"}, {"study", model_.study}, {"models", names}, {"model", index}, {"law", model_.is_law()}, {"dt_s", o.dt_s},
              {"force_max_N", o.safety.force_max_N}, {"force_scale", o.map.force_scale}};
    Eigen::Vector2d low = boxes_[0].first, high = boxes_[0].second;
    for (const auto& [box_low, box_high] : boxes_) low = low.cwiseMin(box_low), high = high.cwiseMax(box_high);
    Json meshes = Json::array();
    for (const auto& mesh : model_.meshes) {
        j["dynamics"][mesh->name] = mesh->dynamics;
        Json nodes = Json::array(), springs = Json::array(), stiffness = Json::array();
        for (int n = 0; n < mesh->springs.node_count(); ++n)
            nodes.push_back(pair(Eigen::Vector2d(mesh->place_m + mesh->springs.rest().row(n).transpose())));
        const Eigen::VectorXd mean = mesh->theta_of_set.rowwise().mean();
        for (Eigen::Index s = 0; s < springs_.rows(); ++s) {
            springs.push_back({springs_(s, 0), springs_(s, 1)});
            stiffness.push_back(mean[mesh->springs.slot_of_spring()[static_cast<std::size_t>(s)]]);
        }
        meshes.push_back({{"name", mesh->name}, {"nodes_m", nodes}, {"fixed", fixed_}, {"springs", springs},
                          {"stiffness_N_m", stiffness}, {"outline", mesh->springs.outline()}});
    }
    j["low_m"] = pair(low);
    j["high_m"] = pair(high);
    j["meshes"] = meshes;
    Json places = Json::array();
    for (const Place& p : places_) {
        Json curve = Json::array();
        for (const auto& [depth, force] : p.curve) curve.push_back({depth, force});
        places.push_back({{"name", p.name}, {"contact_m", pair(p.contact_m)}, {"direction", pair(p.direction)},
                          {"depth_m", p.depth_m}, {"curve", curve}});
    }
    j["places"] = places;
    j["demo"] = first_;
    return j.dump();
}

std::string encode_state(const TickState& s, const HapticModel& model, const Near& near, const TickSummary& sum) {
    static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the page reads little-endian");
    const TickRecord& r = s.record;
    const auto number = [](long long n) { return static_cast<double>(n); };
    const Eigen::Vector2d port = model.options.map.axes * r.device_N;
    const Eigen::Vector2d heuristic = s.contact_displacement_m.size() > 1 ? Eigen::Vector2d(s.contact_displacement_m[1]) : Eigen::Vector2d::Zero();
    const std::array<double, 32> head = {
        r.time_s, number(sum.ticks), number(sum.misses), number(sum.misses_program), number(sum.clamped),
        number(sum.faults), sum.ticks_a_second, sum.p50_us, sum.p99_us,
        r.master_m.x(), r.master_m.y(), r.proxy_m.x(), r.proxy_m.y(), number(r.mesh),
        s.contact_displacement_m[0].x(), s.contact_displacement_m[0].y(), heuristic.x(), heuristic.y(),
        -r.coupling_N.x(), -r.coupling_N.y(), port.x(), port.y(),
        number(near.place), near.force_N, number(r.set), r.fault ? 1.0 : 0.0, number(sum.clients), 0, 0, 0, 0, 0};
    std::string bytes(sizeof head + sizeof(float) * s.nodes_m.size(), '\0');
    std::memcpy(bytes.data(), head.data(), sizeof head);
    std::memcpy(bytes.data() + sizeof head, s.nodes_m.data(), sizeof(float) * s.nodes_m.size());
    return bytes;
}

}  // namespace tissue::serve
