#include "cases/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "cases/solid_sweep.h"
#include "cases/solid_training.h"
#include "cases/study_mesh.h"
#include "cases/surface_contacts.h"
#include "error.h"
#include "mesh/outline.h"

namespace tissue {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;
constexpr double tiny_arc_m = 1e-9, tiny_angle = 1e-9;

/// Whether a contact of a symmetric tissue is solved by FE, and not its mirror image: contacts of the first half of the
/// surface, and at its centre those with an angle of 0 or more.
bool is_solved(const Outline& outline, const SurfaceContact& c) {
    const double half = outline.length() / 2;
    return c.arc < half - tiny_arc_m || (c.arc < half + tiny_arc_m && c.angle > -tiny_angle);
}

/// Names of the contacts: place in 0.1 mm and angle in degrees, both with as many further decimals as make the names
/// different.
std::vector<std::string> names_of(const std::vector<SurfaceContact>& contacts) {
    constexpr int most_decimals = 6;  // different arcs are at least 1e-9 m apart, different angles 1e-6 degrees
    for (int decimals = 0; decimals <= most_decimals; ++decimals) {
        const double scale = std::pow(10, decimals);
        std::vector<std::string> names;
        for (const SurfaceContact& c : contacts)
            names.push_back(fmt::format("s{:0{}.0f}-{}{:0{}.0f}", 1e4 * scale * c.arc, 4 + decimals,
                                        c.angle < -tiny_angle ? "m" : "p", std::abs(c.angle) / degree * scale, 3 + decimals));
        if (std::set<std::string>(names.begin(), names.end()).size() == names.size()) return names;
    }
    throw MismatchError("loads.sweep: two training contacts have the same place and direction");
}

PlannedPath plan_push(const Study& study, const Outline& outline, const SurfaceContact& c, const std::string& name,
                      const std::string& role, double depth_m) {
    PlannedPath path;
    path.push = {name, outline.position(c.arc), outline.direction(c.arc, c.angle)};
    path.role = role;
    path.depth_m = depth_m;
    path.records = std::max(1, static_cast<int>(std::ceil(depth_m / study.loads.record_step_m - 1e-9)));
    path.refine = study.refine;
    return path;
}

/// The same path on the finer mesh.
PlannedPath check_of(const Study& study, PlannedPath path, const std::string& name) {
    path.push.name = name;
    path.role = "check";
    path.refine = study.check_refine;
    return path;
}

std::vector<PlannedPath> listed_paths(const Study& study) {
    std::vector<PlannedPath> paths;
    for (const StudyPath& p : study.loads.paths)
        paths.push_back({p, "train", study.loads.depth_m(), study.loads.records(), study.refine});
    const std::size_t checked = static_cast<std::size_t>(std::lround(study.check_fraction * static_cast<double>(paths.size())));
    for (std::size_t i = 0; study.check_refine > 0 && i < checked; ++i)
        paths.push_back(check_of(study, paths[i], "check-" + paths[i].push.name));
    return paths;
}

std::vector<PlannedPath> swept_paths(const Study& study, const std::optional<Shape>& shape) {
    std::vector<PlannedPath> paths;
    const Outline outline(study_mesh(study, shape, "edges"));
    const std::vector<SurfaceContact> trained = training_contacts(outline, *study.loads.sweep, study.geometry.is_block());
    std::vector<SurfaceContact> solved;
    for (const SurfaceContact& c : trained)
        if (!study.geometry.is_block() || is_solved(outline, c)) solved.push_back(c);
    const std::vector<std::string> names = names_of(solved);
    for (std::size_t i = 0; i < solved.size(); ++i)
        paths.push_back(plan_push(study, outline, solved[i], names[i], "train", study.loads.depth_m()));

    std::vector<PlannedPath> checks;
    for (const Study::Draws& draws : study.draws) {
        ContactDraws drawn(study, draws, outline, trained, "draws." + draws.role);
        for (int i = 1; i <= draws.count; ++i) {
            const SurfaceContact c = drawn.contact();
            const double depth = drawn.uniform(draws.depth_m[0], draws.depth_m[1]);
            std::string name = fmt::format("{}-{:04}", draws.role, i);
            for (char& ch : name)
                if (ch == '_') ch = '-';
            paths.push_back(plan_push(study, outline, c, name, draws.role, depth));
            if (draws.role == "held_out" && study.check_refine > 0 && i <= std::lround(study.check_fraction * draws.count))
                checks.push_back(check_of(study, paths.back(), fmt::format("check-{:04}", i)));
        }
    }
    paths.insert(paths.end(), checks.begin(), checks.end());
    return paths;
}

/// Whether a variant keeps a training path.
std::function<bool(const LoadPath&)> kept_in_the_plane(const Study& study, const Cases& cases, const Study::Variant& variant) {
    const Outline outline(study_mesh(study, cases.shape, "edges"));
    const std::vector<SurfaceContact> contacts =
        training_contacts(outline, {study.loads.sweep->spacing_m, study.loads.sweep->clearance_m, variant.angles_deg, variant.arcs_m},
                          study.geometry.is_block());
    return [outline, contacts](const LoadPath& path) {
        const double arc = outline.arc_of(path.contact_m), angle = outline.angle(arc, path.direction);
        return std::any_of(contacts.begin(), contacts.end(), [&](const SurfaceContact& c) {
            return std::abs(c.arc - arc) < 1e-7 && std::abs(c.angle - angle) < 1e-6;
        });
    };
}

std::function<bool(const LoadPath&)> kept_in_space(const Study& study, const Cases& cases, const Study::Variant& variant) {
    const std::vector<StudyPath> all = solid_training(study, cases.shape);
    std::set<std::string> names;
    for (std::size_t i = 0; i < all.size() && (variant.first_paths == 0 || i < static_cast<std::size_t>(variant.first_paths)); ++i)
        names.insert(all[i].name);
    return [names](const LoadPath& path) { return names.count(path.name) > 0; };
}

}  // namespace

std::vector<PlannedPath> planned_paths(const Study& study, const std::optional<Shape>& shape) {
    std::vector<PlannedPath> paths = study.geometry.is_solid() ? solid_paths(study, shape)
                                     : study.loads.sweep       ? swept_paths(study, shape)
                                                               : listed_paths(study);
    std::set<std::string> names;
    for (const PlannedPath& p : paths)
        if (!names.insert(p.push.name).second)
            throw MismatchError(fmt::format("{}: two load paths would have the name '{}' and the same file", study.file, p.push.name));
    return paths;
}

Cases thinned(const Study& study, const Cases& cases, const Study::Variant& variant) {
    Cases result;
    result.study = cases.study;
    result.nodes = cases.nodes;
    result.shape = cases.shape;
    result.magnitudes_m = variant.magnitudes_m;
    result.histories = cases.histories;
    result.disc_radius_m = cases.disc_radius_m;
    const std::function<bool(const LoadPath&)> kept =
        study.geometry.is_solid() ? kept_in_space(study, cases, variant) : kept_in_the_plane(study, cases, variant);
    for (const LoadPath& path : cases.paths)
        if (path.role != "train" || kept(path)) result.paths.push_back(path);
    return result;
}

}  // namespace tissue
