#include "cases/measured_cases.h"

#include <fmt/format.h>
#include <gsl/gsl_randist.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "error.h"
#include "gsl.h"
#include "mesh/outline.h"

namespace tissue {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;
// Least distance of test and validation from training contacts.
constexpr double apart_m = 0.002;
constexpr double same_contact_m = 0.0002;                    // largest extent of one training place along the surface
constexpr double same_angle = 3 * degree;                    // largest difference of directions of one training path
constexpr double repeat_m = 0.0005, repeat_part = 0.2;       // largest differences of repeats of one indentation
constexpr double outlier = 5;                                // standard deviations
constexpr int least_places = 4;                              // of training

/// One indentation: its rows and their means.
struct Push {
    std::vector<const MeasuredRow*> rows;
    double arc = 0;
    Eigen::Vector2d displacement_m = Eigen::Vector2d::Zero(), force_N = Eigen::Vector2d::Zero();
};

[[noreturn]] void refuse(const MeasuredTable& table, const MeasuredRow& row, const std::string& why) {
    throw FileError(fmt::format("{}:{}: {}", table.file, row.line, why));
}

/// Arc length of a row's contact along the free surface [m]. Refuses a row whose contact, displacement or force is not
/// possible.
double arc_of(const MeasuredTable& table, const MeasuredRow& row, const Outline& outline, double tolerance_m, double size_m) {
    const double arc = outline.arc_of(row.contact_m), off = (outline.position(arc) - row.contact_m).norm();
    if (!(off <= tolerance_m))
        refuse(table, row, fmt::format("columns 'contact_x', 'contact_y': ({:g}, {:g}) m is {} off the free "
                                       "surface; allowed: {:g} mm", row.contact_m.x(), row.contact_m.y(),
                                       length_text(off), 1e3 * tolerance_m));
    if (arc < apart_m || arc > outline.length() - apart_m)
        refuse(table, row, "columns 'contact_x', 'contact_y': the contact is within 2 mm of the fixed edge");
    if (std::abs(outline.angle(arc, row.displacement_m)) >= 90 * degree)
        refuse(table, row, "columns 'displacement_x', 'displacement_y': point out of the tissue");
    if (row.displacement_m.norm() > size_m)
        refuse(table, row, fmt::format("columns 'displacement_x', 'displacement_y': the displacement is {}, more than the tissue's size of {}",
                                       length_text(row.displacement_m.norm()), length_text(size_m)));
    if (!(row.force_N.dot(row.displacement_m) > 0))
        refuse(table, row, "columns 'force_x', 'force_y': the force is against the displacement; give the tool's "
                           "force on the tissue");
    return arc;
}

std::vector<Push> pushes_of(const MeasuredTable& table, const Outline& outline, double tolerance_m, double size_m) {
    std::vector<Push> pushes;
    std::map<std::string, std::size_t> by_name;
    for (const MeasuredRow& row : table.rows) {
        const double arc = arc_of(table, row, outline, tolerance_m, size_m);
        const std::string name = row.push.empty() ? fmt::format("line {}", row.line) : row.push;
        const auto [place, fresh] = by_name.emplace(name, pushes.size());
        if (fresh) pushes.emplace_back();
        Push& push = pushes[place->second];
        if (!fresh) {
            const MeasuredRow& first = *push.rows.front();
            const double reach = std::max(repeat_m, repeat_part * first.displacement_m.norm());
            if ((row.contact_m - first.contact_m).norm() > repeat_m ||
                (row.displacement_m - first.displacement_m).norm() > reach || row.role != first.role)
                refuse(table, row, fmt::format("column 'push': '{}' has on line {} another contact, displacement "
                                               "or role", row.push, first.line));
        }
        push.rows.push_back(&row);
        push.arc += arc;
        push.displacement_m += row.displacement_m;
        push.force_N += row.force_N;
    }
    for (Push& push : pushes) {
        const auto n = static_cast<double>(push.rows.size());
        push.arc /= n;
        push.displacement_m /= n;
        push.force_N /= n;
    }
    return pushes;
}

/// Mean force of the other repeats of a row's indentation [N].
Eigen::Vector2d again(const Push& push, const MeasuredRow& row) {
    const auto n = static_cast<double>(push.rows.size());
    return (n * push.force_N - row.force_N) / (n - 1);
}

void estimate_noise(const std::vector<Push>& pushes, const Study::Data& data, Measurement& m) {
    double force = 0, displacement = 0;
    for (const Push& push : pushes) {
        m.repeats += static_cast<int>(push.rows.size()) - 1;
        for (const MeasuredRow* row : push.rows) {
            force += (row->force_N - push.force_N).squaredNorm() / push.force_N.squaredNorm();
            displacement += (row->displacement_m - push.displacement_m).squaredNorm();
        }
    }
    if (m.repeats > 0) {  // each degree of freedom has two components
        m.force_noise = std::sqrt(force / (2.0 * m.repeats));
        m.displacement_noise_m = std::sqrt(displacement / (2.0 * m.repeats));
        m.noise_source = "repeats";
    } else {
        m.force_noise = data.stated_force_noise.value_or(0);
        m.noise_source = data.stated_force_noise ? "stated" : "unknown";
    }
    for (const Push& push : pushes)
        for (const MeasuredRow* row : push.rows) {
            if (push.rows.size() < 2 || m.force_noise == 0) continue;
            const auto n = static_cast<double>(push.rows.size());
            const double away = (row->force_N - again(push, *row)).norm() / push.force_N.norm();
            const double expected = m.force_noise * std::sqrt(1 + 1 / (n - 1));
            if (away > outlier * expected)
                m.outliers.push_back(fmt::format("line {}: differs from its repeats by {:.1f} %, {:.1f} standard deviations",
                                                 row->line, 100 * away, away / expected));
        }
}

std::vector<Push*> along_the_surface(std::vector<Push>& pushes) {
    std::vector<Push*> sorted;
    for (Push& p : pushes) sorted.push_back(&p);
    std::stable_sort(sorted.begin(), sorted.end(), [](const Push* a, const Push* b) { return a->arc < b->arc; });
    return sorted;
}

/// Groups the indentations by contact, split wherever neighbours along the surface are `apart_m` or more apart. A group
/// may be of any length, so that no indentations of different groups are nearer than that.
std::vector<std::vector<Push*>> contacts_of(std::vector<Push>& pushes) {
    std::vector<std::vector<Push*>> contacts;
    for (Push* p : along_the_surface(pushes)) {
        if (contacts.empty() || p->arc - contacts.back().back()->arc >= apart_m) contacts.emplace_back();
        contacts.back().push_back(p);
    }
    return contacts;
}

/// Groups the training indentations by place. No place is longer than `same_contact_m`, because the mean of a long row
/// of closely spaced indentations would stand for none of them.
std::vector<std::vector<Push*>> places_of(std::vector<Push>& pushes) {
    std::vector<std::vector<Push*>> places;
    for (Push* p : along_the_surface(pushes)) {
        if (places.empty() || p->arc - places.back().front()->arc >= same_contact_m) places.emplace_back();
        places.back().push_back(p);
    }
    return places;
}

/// Draws the role of each contact by the study's seed.
std::vector<std::string> draw_roles(const std::vector<std::vector<Push*>>& contacts, const Outline& outline,
                                    const Study::Data& data) {
    std::vector<std::size_t> free;
    for (std::size_t i = 1; i + 1 < contacts.size(); ++i) {
        bool corner = false;
        for (double c : outline.corners())
            corner |= contacts[i].front()->arc < c + apart_m && contacts[i].back()->arc > c - apart_m;
        if (!corner) free.push_back(i);
    }
    const Rng rng = seeded_rng(data.seed);
    // of an empty list GSL would count down from the index 0 - 1, the largest std::size_t
    if (!free.empty()) gsl_ran_shuffle(rng.get(), free.data(), free.size(), sizeof free[0]);
    const auto part = [&](double p) -> std::size_t {
        return p > 0 ? static_cast<std::size_t>(std::max(1L, std::lround(p * static_cast<double>(contacts.size())))) : 0;
    };
    std::vector<std::string> roles(contacts.size(), "train");
    const std::size_t proof = part(data.held_out_part), choice = part(data.validation_part);
    for (std::size_t k = 0; k < free.size() && k < proof + choice; ++k)
        roles[free[k]] = k < proof ? "held_out" : "validation";
    return roles;
}

/// Adds the training indentations at one place, one path for each direction.
void add_training(Cases& cases, const Outline& outline, const std::vector<Push*>& pushes) {
    double arc = 0;
    for (const Push* p : pushes) arc += p->arc / static_cast<double>(pushes.size());
    std::vector<std::pair<double, const Push*>> by_angle;
    for (const Push* p : pushes) by_angle.emplace_back(outline.angle(arc, p->displacement_m), p);
    std::stable_sort(by_angle.begin(), by_angle.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t first = 0, last = 0; first < by_angle.size(); first = last) {
        double angle = 0;
        while (last < by_angle.size() && by_angle[last].first - by_angle[first].first < same_angle) angle += by_angle[last++].first;
        angle /= static_cast<double>(last - first);
        LoadPath path;
        path.name = fmt::format("s{:06.0f}-{}{:05.0f}", 1e6 * arc, angle < 0 ? "m" : "p", 1e2 * std::abs(angle) / degree);
        path.contact_m = outline.position(arc);
        path.direction = outline.direction(arc, angle);
        std::map<long, std::vector<const Push*>> by_depth;  // rounded to 0.1 um; the records of a path have to ascend
        for (std::size_t i = first; i < last; ++i) {
            const Push* p = by_angle[i].second;
            by_depth[std::lround(1e7 * p->displacement_m.dot(path.direction))].push_back(p);
        }
        for (const auto& entry : by_depth) {
            Eigen::Vector2d displacement = Eigen::Vector2d::Zero(), force = displacement;
            for (const Push* p : entry.second) {
                displacement += p->displacement_m / static_cast<double>(entry.second.size());
                force += p->force_N / static_cast<double>(entry.second.size());
            }
            const double magnitude = displacement.dot(path.direction);
            path.records.push_back(measured_record(magnitude, force, displacement - magnitude * path.direction));
        }
        path.depth_m = path.records.back().magnitude_m;
        cases.paths.push_back(std::move(path));
    }
}

/// Makes names different: names are rounded to 0.001 mm and 0.01 degrees, and all but the first of equal ones get a
/// number.
void name_apart(std::vector<LoadPath>& paths) {
    std::set<std::string> names;
    for (LoadPath& path : paths) {
        const std::string name = path.name;
        for (int i = 2; !names.insert(path.name).second; ++i) path.name = fmt::format("{}-{}", name, i);
    }
}

void add_held_out(Cases& cases, const Outline& outline, const Push& push, const std::string& role) {
    for (const MeasuredRow* row : push.rows) {
        LoadPath path;
        path.name = fmt::format("{}-line-{}", role, row->line);
        std::replace(path.name.begin(), path.name.end(), '_', '-');
        path.contact_m = outline.position(outline.arc_of(row->contact_m));
        path.direction = row->displacement_m.normalized();
        path.role = role;
        path.depth_m = row->displacement_m.norm();
        path.records = {measured_record(path.depth_m, row->force_N, Eigen::Vector2d::Zero())};
        if (push.rows.size() > 1) path.again_N = again(push, *row);
        cases.paths.push_back(std::move(path));
    }
}

}  // namespace

Cases measured_cases(const Study& study, const MeasuredTable& table) {
    const SpringMesh lattice = make_lattice("grid4", study.lattice());
    const Outline outline(lattice);
    std::vector<Push> pushes = pushes_of(table, outline, study.data->surface_tolerance_m, lattice.size_m());
    const std::vector<std::vector<Push*>> contacts = contacts_of(pushes);

    Cases cases;
    cases.study = study.name;
    cases.nodes = lattice.nodes;
    cases.measurement.emplace();
    cases.measurement->origin = table.origin;
    cases.measurement->rows = static_cast<int>(table.rows.size());
    cases.measurement->contacts = static_cast<int>(contacts.size());
    estimate_noise(pushes, *study.data, *cases.measurement);

    std::vector<std::string> roles;
    if (table.rows.front().role.empty()) {
        roles = draw_roles(contacts, outline, *study.data);
    } else
        for (const std::vector<Push*>& contact : contacts) {
            for (std::size_t i = 1; i < contact.size(); ++i) {
                const MeasuredRow &row = *contact[i]->rows.front(), &before = *contact[i - 1]->rows.front();
                if ((row.role == "train") != (before.role == "train"))
                    refuse(table, row, fmt::format("column 'role': '{}', less than 2 mm along the surface from the '{}' of "
                                                   "line {}; the test set and the training set must be apart", row.role,
                                                   before.role, before.line));
            }
            // "": the roles of its rows are used, validation or held_out
            roles.push_back(contact.front()->rows.front()->role == "train" ? "train" : "");
        }

    std::vector<Push> trained;
    for (std::size_t i = 0; i < contacts.size(); ++i)
        for (Push* p : contacts[i]) {
            if (roles[i] == "train") trained.push_back(*p);
        }
    const std::vector<std::vector<Push*>> places = places_of(trained);
    for (const std::vector<Push*>& place : places) add_training(cases, outline, place);
    bool proved = false;
    for (std::size_t i = 0; i < contacts.size(); ++i)
        for (const Push* p : contacts[i]) {
            if (roles[i] == "train") continue;
            const std::string role = roles[i].empty() ? p->rows.front()->role : roles[i];
            add_held_out(cases, outline, *p, role);
            proved |= role == "held_out";
        }
    if (places.size() < least_places || !proved)
        throw FileError(fmt::format("{}: has {} rows at {} contacts, with {} places to train on and {} contact for the test set; at least "
                                    "{} and 1 are needed", table.file, table.rows.size(), contacts.size(), places.size(),
                                    proved ? "a" : "no", least_places));
    name_apart(cases.paths);
    return cases;
}

}  // namespace tissue
