#include "scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "mesh/outline.h"

namespace tissue::serve {
namespace {

using Json = nlohmann::ordered_json;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

Json numbers(const Point& v) {
    return std::vector<double>(v.data(), v.data() + v.size());
}

/// "left-10mm" -> "left": the common part of the names of one place's cases.
std::string without_depth(const std::string& name) {
    const std::size_t dash = name.rfind('-');
    const bool depth = dash != std::string::npos && name.size() > dash + 2 && name.compare(name.size() - 2, 2, "mm") == 0;
    return depth ? name.substr(0, dash) : name;
}

double at_depth(const std::vector<std::pair<double, double>>& curve, double depth_m) {
    if (depth_m < 0) return unknown;
    for (std::size_t k = 1; k < curve.size(); ++k) {
        const auto &a = curve[k - 1], &b = curve[k];
        if (depth_m <= b.first) return a.second + (b.second - a.second) * (depth_m - a.first) / (b.first - a.first);
    }
    return unknown;
}

Json learned_json(const LearnedField& learned, const std::vector<int>& shown) {
    Json factor = Json::array(), sd = Json::array();
    for (int n : shown) factor.push_back(learned.factor[n]), sd.push_back(learned.sd[n]);
    return {{"pokes", learned.pokes}, {"factor", factor}, {"sd", sd}};
}

/// node_shown: number of a node on the page.
template <class NodeShown>
Json nodule_json(const NoduleSurface& nodule, const CarriedPoints& carried, const Point& place_m, const NodeShown& node_shown) {
    Json points = Json::array(), facets = Json::array(), nodes = Json::array(), weights = Json::array();
    for (const auto& p : nodule.points.rowwise()) points.push_back(numbers(p.transpose() + place_m));
    for (const auto& t : nodule.triangles.rowwise()) facets.push_back({t[0], t[1], t[2]});
    for (const auto& n : carried.node.rowwise()) nodes.push_back({node_shown(n[0]), node_shown(n[1]), node_shown(n[2]), node_shown(n[3])});
    for (const auto& w : carried.weight.rowwise()) weights.push_back({w[0], w[1], w[2], w[3]});
    return {{"points_m", points}, {"facets", facets}, {"nodes", nodes}, {"weights", weights}};
}

Json errors_json(const std::vector<ReferenceError>& errors) {
    Json all = Json::array();
    for (const ReferenceError& e : errors)
        all.push_back({{"role", e.role}, {"contact_m", numbers(e.contact_m)}, {"direction", numbers(e.direction)}, {"inward", numbers(e.inward)},
                       {"depth_m", e.depth_m}, {"error", e.force ? Json(*e.force) : Json()}});
    return all;
}

/// Appends the numbers of a matrix to bytes, in row-major order, little-endian.
template <class Number, class Matrix>
void append(std::string& bytes, const Matrix& matrix) {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
        for (Eigen::Index k = 0; k < matrix.cols(); ++k) {
            const auto number = static_cast<Number>(matrix(i, k));
            bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
        }
}

}  // namespace

Scene::Scene(const TissueModel& tissue, const HapticModel& model, const std::vector<NodeField>& fe_displacement_m, std::optional<LearnedField> learned)
    : model_(model), mesh_(tissue.mesh), surface_(tissue.mesh),
      learned_(std::move(learned)), nodule_(tissue.nodule) {
    if (tissue.energy_model) tau_s_ = tissue.energy_model->relaxation.tau_s, contact_share_ = tissue.energy_model->relaxation.contact_share;
    for (const auto& mesh : model.meshes) boxes_.emplace_back(mesh->place_m + model.low_m, mesh->place_m + model.high_m);
    if (mesh_.is_solid()) {
        shown_.assign(mesh_.facets.data(), mesh_.facets.data() + mesh_.facets.size());
        if (!nodule_.empty()) nodule_carried_ = carried_points(mesh_, nodule_.points);
        shown_.insert(shown_.end(), nodule_carried_.node.data(), nodule_carried_.node.data() + nodule_carried_.node.size());
        std::sort(shown_.begin(), shown_.end());
        shown_.erase(std::unique(shown_.begin(), shown_.end()), shown_.end());
    } else {
        shown_.resize(static_cast<std::size_t>(mesh_.node_count()));
        std::iota(shown_.begin(), shown_.end(), 0);
    }
    const std::vector<int> surface = mesh_.is_solid() ? shown_ : mesh_.loop();   // nodes whose FE displacement is sent
    std::optional<Outline> outline;
    if (!mesh_.is_solid()) outline.emplace(mesh_);
    const auto inward = [&](const Point& contact) -> Point {
        if (outline) return outline->inward_normal(outline->arc_of(contact));
        return surface_.nearest(contact).inward;
    };
    const bool forces = tissue.contact_force_N.rows() > 0;
    for (int c = 0; c < tissue.case_count(); ++c) {
        if (!tissue.is_own_case(c)) continue;  // a load case of another disc is no reference for this one
        const Point contact = tissue.contact_m.row(c), direction = tissue.direction.row(c);
        std::size_t k = 0;
        while (k < places_.size() && ((places_[k].contact_m - contact).norm() > 1e-9 || (places_[k].direction - direction).norm() > 1e-9))
            ++k;
        if (k == places_.size())
            places_.push_back({without_depth(tissue.case_names[static_cast<std::size_t>(c)]), contact, direction, inward(contact), 0, {}, {}});
        Place& place = places_[k];
        place.depth_m = std::max(place.depth_m, tissue.magnitude_m[c]);
        if (forces) place.curve.emplace_back(tissue.magnitude_m[c], tissue.contact_force_N.row(c).dot(direction));
        if (!fe_displacement_m.empty())
            place.outlines.push_back(
                {tissue.magnitude_m[c], fe_displacement_m[static_cast<std::size_t>(c)](surface, Eigen::all)});
    }
    for (Place& place : places_) {
        if (!place.outlines.empty())
            place.outlines.push_back({0, NodeField::Zero(static_cast<Eigen::Index>(surface.size()), dimension())});
        std::sort(place.outlines.begin(), place.outlines.end(),
                  [](const FeOutline& a, const FeOutline& b) { return a.depth_m < b.depth_m; });
        if (place.curve.empty()) continue;
        place.curve.emplace_back(0, 0);
        std::sort(place.curve.begin(), place.curve.end());
    }
    Point top = 0.5 * (model.low_m + model.high_m);
    top[dimension() - 1] = model.high_m[dimension() - 1];
    const double width = model.high_m[0] - model.low_m[0];
    double best = -1e9;
    for (std::size_t k = 0; k < places_.size(); ++k) {
        const double merit = places_[k].direction.dot(places_[k].inward) - (places_[k].contact_m - top).norm() / width;
        if (merit > best) best = merit, first_ = static_cast<int>(k);
    }
}

void Scene::know(std::vector<ReferenceError> errors) {
    errors_ = std::move(errors);
    for (ReferenceError& e : errors_) e.inward = surface_.nearest(e.contact_m).inward;
}

void Scene::carry(const CarriedSurface& surface) {
    const auto shown_as = [&](int node) { return std::lower_bound(shown_.begin(), shown_.end(), node) - shown_.begin(); };
    carried_.clear();
    append<std::uint32_t>(carried_, Eigen::RowVector2i(static_cast<int>(surface.vertices.rows()), static_cast<int>(surface.facets.rows())));
    append<float>(carried_, surface.vertices.rowwise() + model_.meshes[0]->place_m.transpose());
    append<std::uint32_t>(carried_, surface.facets);
    append<std::uint32_t>(carried_, surface.node.unaryExpr(shown_as));
    append<float>(carried_, surface.weight);
}

Touch Scene::nearest(const Point& p) const {
    Touch touch;
    double best = std::numeric_limits<double>::infinity();
    for (const auto& mesh : model_.meshes) {
        const FreeSurface::Place here = surface_.nearest(p - mesh->place_m);
        if (!(here.distance_m < best)) continue;
        best = here.distance_m;
        touch = {mesh->place_m + here.point_m, here.inward};
    }
    return touch;
}

Near Scene::near(const TickState& state) const {
    Near near{-1, 0, unknown};
    if (state.record.mesh < 0) return near;
    const Point contact = model_.meshes[0]->springs.rest_place(state.record.facet, state.record.weight);
    const Point push = state.contact_displacement_m[0];
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

bool Scene::away_from_rest(const TickState& state) const {
    constexpr double swing = 0.3;
    const double far_m = swing * surface_.spacing_m();
    const Eigen::Index nodes = mesh_.node_count(), d = dimension();
    const float* at = state.nodes_m.data();
    for (const auto& mesh : model_.meshes)
        for (Eigen::Index n = 0; n < nodes; ++n, at += d) {
            const Point p = Eigen::Map<const Eigen::VectorXf>(at, d).cast<double>();
            if (!((p - mesh->place_m - mesh->springs.rest().row(n).transpose()).norm() < far_m)) return true;
        }
    return false;
}

std::string Scene::message(const Lesson::News& news) const {
    Json j = {{"type", "learned"}};
    if (!news.ended.empty()) j["ended"] = news.ended;
    if (learned_) j["learned"] = learned_json(*learned_, shown_);
    if (news.poke) j["reading"] = {{"contact_m", numbers(news.poke->contact_m)}, {"push_m", numbers(news.poke->push_m)}, {"status", to_string(news.status)},
                                   {"why", news.why}, {"warning", news.warning}};
    if (news.next) j["next"] = {{"contact_m", numbers(news.next->contact_m)}, {"push_m", numbers(news.next->push_m)}};
    return j.dump();
}

std::string Scene::message(const std::vector<std::string>& names, int index) const {
    const HapticOptions& o = model_.options;
    Json j = {{"type", "model"}, {"study", model_.study}, {"models", names}, {"model", index}, {"dimension", dimension()},
              {"law", model_.is_energy_model()}, {"grasps", model_.grasps(0) || (o.tools > 1 && model_.grasps(1))}, {"tools", o.tools}, {"dt_s", o.dt_s}, {"force_max_N", o.safety.force_max_N}, {"force_scale", o.map.force_scale},
              {"node_count", mesh_.node_count()}, {"spring_count", mesh_.spring_count()}};
    if (tau_s_.size() > 0) j["relaxation"] = {{"tau_s", numbers(tau_s_)}, {"share", numbers(contact_share_)}};
    if (learned_) j["learned"] = learned_json(*learned_, shown_);
    if (learns()) j["learns"] = true;
    Point low = boxes_[0].first, high = boxes_[0].second;
    for (const auto& [box_low, box_high] : boxes_) low = low.cwiseMin(box_low), high = high.cwiseMax(box_high);
    const auto shown_as = [&](int node) { return std::lower_bound(shown_.begin(), shown_.end(), node) - shown_.begin(); };
    Json fixed = Json::array(), facets = Json::array();
    for (int node : mesh_.fixed)
        if (std::binary_search(shown_.begin(), shown_.end(), node)) fixed.push_back(shown_as(node));
    if (mesh_.is_solid())
        for (const auto& facet : mesh_.facets.rowwise()) facets.push_back({shown_as(facet[0]), shown_as(facet[1]), shown_as(facet[2])});
    Json meshes = Json::array();
    for (const auto& mesh : model_.meshes) {
        j["dynamics"][mesh->name] = mesh->dynamics;
        Json nodes = Json::array();
        for (int n : shown_) nodes.push_back(numbers(mesh->place_m + mesh->springs.rest().row(n).transpose()));
        Json m = {{"name", mesh->name}, {"nodes_m", nodes}, {"fixed", fixed}};
        if (mesh_.is_solid()) {
            m["facets"] = facets;
        } else {
            Json springs = Json::array(), stiffness = Json::array();
            const Eigen::VectorXd mean = mesh->theta_of_set.rowwise().mean();
            for (Eigen::Index s = 0; s < mesh_.springs.rows(); ++s) {
                springs.push_back({mesh_.springs(s, 0), mesh_.springs(s, 1)});
                stiffness.push_back(mean[mesh->springs.slot_of_spring()[static_cast<std::size_t>(s)]]);
            }
            m["springs"] = springs;
            m["stiffness_N_m"] = stiffness;
            m["outline"] = mesh_.loop();
        }
        meshes.push_back(m);
    }
    j["low_m"] = numbers(low);
    j["high_m"] = numbers(high);
    j["meshes"] = meshes;
    if (mesh_.is_solid())
        for (const ToolChoice& tool : model_.tools) j["tool"].push_back({{"shape", to_string(tool.shape)}, {"radius_m", tool.radius_m}});
    if (!carried_.empty()) j["surface"] = true;
    if (!nodule_.empty()) j["nodule"] = nodule_json(nodule_, nodule_carried_, model_.meshes[0]->place_m, shown_as);
    if (!errors_.empty()) j["errors"] = errors_json(errors_);
    Json places = Json::array();
    for (const Place& p : places_) {
        Json curve = Json::array();
        for (const auto& [depth, force] : p.curve) curve.push_back({depth, force});
        Json place = {{"name", p.name}, {"contact_m", numbers(p.contact_m)}, {"direction", numbers(p.direction)},
                      {"depth_m", p.depth_m}, {"curve", curve}};
        if (mesh_.is_solid()) place["inward"] = numbers(p.inward);
        places.push_back(place);
    }
    j["places"] = places;
    j["demo"] = first_;
    return j.dump();
}

}  // namespace tissue::serve
