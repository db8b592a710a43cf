#include "cases/sweep.h"

#include <fmt/format.h>
#include <gsl/gsl_rng.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <set>

#include "cases/solid_sweep.h"
#include "cases/solid_training.h"
#include "cases/study_mesh.h"
#include "error.h"
#include "mesh/outline.h"

namespace tissue {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;
constexpr double least_arc_m = 0.002, least_angle = 5 * degree;  // what "held out" means, beside the seed
constexpr double tiny_arc_m = 1e-9, tiny_angle = 1e-9;

struct Contact {
    double arc, angle;
};

/// Angles of a training position: at a corner of the outline those of both sides, so that neighbours on either side
/// find their own pushes there.
std::vector<double> angles_at(const Outline& outline, double arc, const std::vector<double>& angles_deg) {
    const std::vector<double> corners = outline.corners();
    const bool corner = std::any_of(corners.begin(), corners.end(), [&](double c) { return std::abs(c - arc) < tiny_arc_m; });
    const double step = 1e-6;  // [m] to either side
    std::set<long> micro_degrees;
    for (double side : {-step, step}) {
        const double turn = corner ? outline.angle(arc, outline.inward_normal(arc + side)) : 0;
        for (double a : angles_deg) micro_degrees.insert(std::lround((a * degree + turn) / degree * 1e6));
    }
    std::vector<double> angles;
    for (long a : micro_degrees) {  // two sides' pushes within a degree of each other are one
        const double angle = static_cast<double>(a) * 1e-6 * degree;
        if (!corner || angles.empty() || angle - angles.back() > degree) angles.push_back(angle);
    }
    return angles;
}

/// The study's own list; mirrors: with the places in the other half that they stand for.
std::vector<double> listed_arcs(const Outline& outline, const Study::Loads::Sweep& sweep, bool mirrors) {
    std::vector<double> arcs;
    const auto add = [&](double arc) {
        if (std::none_of(arcs.begin(), arcs.end(), [&](double a) { return std::abs(a - arc) < tiny_arc_m; })) arcs.push_back(arc);
    };
    for (double arc : sweep.arcs_m) {
        if (arc < sweep.clearance_m - tiny_arc_m || arc > outline.length() - sweep.clearance_m + tiny_arc_m)
            throw MismatchError(fmt::format("loads.sweep.arcs_m: {:g} is not between clearance_m = {:g} and {:g}, as far from the "
                                            "surface's other end", arc, sweep.clearance_m, outline.length() - sweep.clearance_m));
        add(arc);
        if (mirrors) add(outline.length() - arc);
    }
    std::sort(arcs.begin(), arcs.end());
    return arcs;
}

/// mirrors: the tissue is the same in the mirror, and so are its contacts.
std::vector<Contact> training_contacts(const Outline& outline, const Study::Loads::Sweep& sweep, bool mirrors) {
    std::vector<Contact> contacts;
    if (!sweep.arcs_m.empty()) {
        for (double arc : listed_arcs(outline, sweep, mirrors))
            for (double angle : angles_at(outline, arc, sweep.angles_deg)) contacts.push_back({arc, angle});
        return contacts;
    }
    const int count = static_cast<int>(std::floor((outline.length() - 2 * sweep.clearance_m) / sweep.spacing_m + 1e-9));
    std::vector<double> arcs;
    for (int i = 0; i <= count; ++i) arcs.push_back(sweep.clearance_m + i * sweep.spacing_m);
    // corners always: directions jump there
    for (double corner : outline.corners())
        if (std::none_of(arcs.begin(), arcs.end(), [&](double a) { return std::abs(a - corner) < tiny_arc_m; }))
            arcs.push_back(corner);
    std::sort(arcs.begin(), arcs.end());
    for (double arc : arcs) {
        for (double angle : angles_at(outline, arc, sweep.angles_deg)) contacts.push_back({arc, angle});
    }
    return contacts;
}

/// Whether a contact stands for its mirror image: the first half of the surface, and in the middle pushes to one side.
bool is_solved(const Outline& outline, const Contact& c) {
    const double half = outline.length() / 2;
    return c.arc < half - tiny_arc_m || (c.arc < half + tiny_arc_m && c.angle > -tiny_angle);
}

/// A name a contact: place in 0.1 mm and angle in degrees, both with as many more decimals as tell all of them apart.
std::vector<std::string> names_of(const std::vector<Contact>& contacts) {
    constexpr int most_decimals = 6;  // arcs lie 1e-9 m apart, angles 1e-6 degrees
    for (int decimals = 0; decimals <= most_decimals; ++decimals) {
        const double scale = std::pow(10, decimals);
        std::vector<std::string> names;
        for (const Contact& c : contacts)
            names.push_back(fmt::format("s{:0{}.0f}-{}{:0{}.0f}", 1e4 * scale * c.arc, 4 + decimals,
                                        c.angle < -tiny_angle ? "m" : "p", std::abs(c.angle) / degree * scale, 3 + decimals));
        if (std::set<std::string>(names.begin(), names.end()).size() == names.size()) return names;
    }
    throw MismatchError("loads.sweep: two training contacts are at one place and push in one direction");
}

PlannedPath plan_push(const Study& study, const Outline& outline, const Contact& c, const std::string& name,
                      const std::string& role, double depth_m) {
    PlannedPath path;
    path.push = {name, outline.position(c.arc), outline.direction(c.arc, c.angle)};
    path.role = role;
    path.depth_m = depth_m;
    path.records = std::max(1, static_cast<int>(std::ceil(depth_m / study.loads.record_step_m - 1e-9)));
    path.refine = study.refine;
    return path;
}

/// The same push on the finer mesh.
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
    const std::vector<Contact> trained = training_contacts(outline, *study.loads.sweep, study.geometry.is_block());
    std::vector<Contact> solved;
    for (const Contact& c : trained)
        if (!study.geometry.is_block() || is_solved(outline, c)) solved.push_back(c);
    const std::vector<std::string> names = names_of(solved);
    for (std::size_t i = 0; i < solved.size(); ++i)
        paths.push_back(plan_push(study, outline, solved[i], names[i], "train", study.loads.depth_m()));

    std::vector<PlannedPath> checks;
    for (const Study::Draws& draws : study.draws) {
        const std::unique_ptr<gsl_rng, void (*)(gsl_rng*)> rng(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free);
        gsl_rng_set(rng.get(), draws.seed);
        const auto uniform = [&rng](double low, double high) { return low + (high - low) * gsl_rng_uniform(rng.get()); };
        const double clearance = study.loads.sweep->clearance_m;
        int tries = 0;
        for (int i = 1; i <= draws.count; ++i) {
            Contact c{};
            bool apart = false;
            while (!apart) {
                if (++tries > 1000 * draws.count)
                    throw MismatchError(fmt::format("draws.{}: the training contacts leave no room for contacts 2 mm or "
                                                    "5 degrees away from all of them", draws.role));
                c = {uniform(clearance, outline.length() - clearance),
                     uniform(-draws.max_angle_deg, draws.max_angle_deg) * degree};
                const Eigen::Vector2d push = outline.direction(c.arc, c.angle);
                apart = true;
                for (const Contact& t : trained)
                    if (std::abs(t.arc - c.arc) < least_arc_m &&
                        std::abs(outline.angle(t.arc, push) - t.angle) < least_angle)
                        apart = false;
            }
            const double depth = uniform(draws.depth_m[0], draws.depth_m[1]);
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
    const std::vector<Contact> contacts =
        training_contacts(outline, {study.loads.sweep->spacing_m, study.loads.sweep->clearance_m, variant.angles_deg, variant.arcs_m},
                          study.geometry.is_block());
    return [outline, contacts](const LoadPath& path) {
        const double arc = outline.arc_of(path.contact_m), angle = outline.angle(arc, path.direction);
        return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
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
            throw MismatchError(fmt::format("{}: two load paths would be named '{}', and share one file", study.file, p.push.name));
    return paths;
}

Cases thinned(const Study& study, const Cases& cases, const Study::Variant& variant) {
    Cases result;
    result.study = cases.study;
    result.nodes = cases.nodes;
    result.shape = cases.shape;
    result.magnitudes_m = variant.magnitudes_m;
    const std::function<bool(const LoadPath&)> kept =
        study.geometry.is_solid() ? kept_in_space(study, cases, variant) : kept_in_the_plane(study, cases, variant);
    for (const LoadPath& path : cases.paths)
        if (path.role != "train" || kept(path)) result.paths.push_back(path);
    return result;
}

}  // namespace tissue
