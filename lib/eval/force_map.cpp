#include "eval/force_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "error.h"
#include "parallel.h"
#include "springs/indentation_solver.h"

namespace tissue {
namespace {

constexpr double same_m = 1e-6;  // [m], difference below which two distances are equal

std::optional<ForceMap::Contrast> contrast_of(const ForceMap& map, const NodeField& ground) {
    if (map.places.size() < 2 || ground.rows() == 0) return {};
    const Point nodule_m = ground.leftCols(3).colwise().mean().transpose();
    const auto away_m = [&](const ForceMap::Place& p) { return (p.contact_m - nodule_m).norm(); };
    const auto nearer = [&](const ForceMap::Place& a, const ForceMap::Place& b) { return away_m(a) < away_m(b); };
    const ForceMap::Place& over = *std::min_element(map.places.begin(), map.places.end(), nearer);
    const double far_m = away_m(*std::max_element(map.places.begin(), map.places.end(), nearer));
    ForceMap::Contrast contrast{over.contact_m, {}, 0, over.learned_N};
    double fe_N = 0, learned_N = 0;
    bool answered = over.learned_N.has_value();
    for (const ForceMap::Place& p : map.places) {
        if (away_m(p) < far_m - same_m) continue;
        contrast.far_m.push_back(p.contact_m);
        fe_N += p.fe_N;
        answered = answered && p.learned_N;
        learned_N += p.learned_N.value_or(0);
    }
    const auto count = static_cast<double>(contrast.far_m.size());
    contrast.fe = over.fe_N / (fe_N / count);
    contrast.learned = answered ? std::optional<double>(*over.learned_N / (learned_N / count)) : std::nullopt;
    return contrast;
}

}  // namespace

Statistics ForceMap::error() const {
    std::vector<double> errors;
    for (const Place& p : places) {
        const double off_N = p.learned_N ? std::abs(*p.learned_N - p.fe_N) : std::numeric_limits<double>::infinity();
        errors.push_back(p.fe_N != 0 ? off_N / std::abs(p.fe_N) : std::numeric_limits<double>::quiet_NaN());
    }
    return statistics_of(errors, static_cast<int>(lost.size()));
}

ForceMap force_map(const TissueModel& model, const Cases& cases, int threads) {
    ForceMap map;
    std::vector<const LoadPath*> paths;
    for (const LoadPath& path : cases.paths) {
        if (path.role != "map") continue;
        map.depth_m = path.depth_m;
        if (path.lost.empty())
            paths.push_back(&path);
        else
            map.lost.push_back(path.name + ": " + path.lost);
    }
    if (map.lost.empty() && paths.empty()) return map;
    if (!model.energy_model) throw MismatchError("a force map needs an energy model, and this model has spring sets");
    const IndentationSolver solver(model);
    map.places.resize(paths.size());
    parallel_for(static_cast<int>(paths.size()), threads, [&](int i) {
        const LoadPath& path = *paths[static_cast<std::size_t>(i)];
        const PathRecord& record = path.records.back();
        ForceMap::Place& place = map.places[static_cast<std::size_t>(i)];
        place = {path.name, path.contact_m, record.contact_force_N.dot(path.direction), {}};
        const Equilibrium state = solver.at(path.contact_m, path.push_m(record));
        if (state) place.learned_N = state.contact_force.dot(path.direction);
    });
    map.contrast = contrast_of(map, model.energy_model->disc.ground);
    return map;
}

}  // namespace tissue
