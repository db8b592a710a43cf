#include "cases/measured_histories.h"

#include <fmt/format.h>
#include <gsl/gsl_randist.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <set>

#include "cases/measured_csv.h"
#include "cases/study_mesh.h"
#include "error.h"
#include "gsl.h"
#include "io/csv_columns.h"
#include "io/csv_table.h"
#include "io/dataset_name.h"
#include "mesh/outline.h"

namespace tissue {
namespace {

constexpr std::size_t least_rows = 8;
constexpr double same_contact_m = 0.0002, apart_m = 0.002;
constexpr double at_rest = 0.05;  // largest first displacement of a history, over its largest one

const std::vector<CsvColumn> known = {
    {"history", nullptr, true},                {"time", &time_units(), true},             {"contact_x", &length_units(), true},
    {"contact_y", &length_units(), true},      {"displacement_x", &length_units(), true}, {"displacement_y", &length_units(), true},
    {"force_x", &force_units(), true},         {"force_y", &force_units(), true},         {"kind", nullptr, false},
    {"role", nullptr, false}};

struct Row {
    double time_s;
    Eigen::Vector2d push_m, force_N;
};

/// One history while its rows are read.
struct Rows {
    int line;
    Eigen::Vector2d contact_m;
    std::string name, kind, role;
    std::vector<Row> rows;
};

[[noreturn]] void refuse(const std::string& file, const Rows& h, const std::string& why) {
    throw FileError(fmt::format("{}:{}: history '{}' {}", file, h.line, h.name, why));
}

std::vector<Rows> read_rows(const std::string& file) {
    CsvTable line(file);
    CsvColumns columns;
    std::vector<Rows> all;
    std::set<std::string> names;
    while (line.next()) {
        if (line.is_comment()) continue;
        if (columns.empty()) {
            columns = CsvColumns(line, known);
            continue;
        }
        columns.check(line);
        const std::string name = columns.text(line, "history"), kind = columns.text(line, "kind"), role = columns.text(line, "role");
        const Eigen::Vector2d contact(columns.number(line, "contact_x"), columns.number(line, "contact_y"));
        if (name.empty()) line.refuse("column 'history' is empty");
        if (!can_name_a_dataset(name))  // else cases.h5 could not be read again
            line.refuse(fmt::format("column 'history' is '{}'; a name must have no '/' and no control character, and must not be '.' or '..'", name));
        if (columns.has("role") && role != "train" && role != "validation" && role != "held_out")
            line.refuse(fmt::format("column 'role' is '{}'; allowed: train, validation, held_out", role));
        if (all.empty() || all.back().name != name) {
            if (!names.insert(name).second) line.refuse(fmt::format("history '{}' continues here after another one: its rows must follow each other", name));
            all.push_back({line.number(), contact, name, kind, role, {}});
        }
        Rows& h = all.back();
        if ((contact - h.contact_m).norm() > same_contact_m) line.refuse(fmt::format("history '{}' has another contact than on line {}", name, h.line));
        if (kind != h.kind || role != h.role) line.refuse(fmt::format("history '{}' has another kind or role than on line {}", name, h.line));
        const double time_s = columns.number(line, "time");
        if (!h.rows.empty() && !(time_s > h.rows.back().time_s))
            line.refuse(fmt::format("column 'time': {:g} s is not later than {:g} s", time_s, h.rows.back().time_s));
        h.rows.push_back({time_s, {columns.number(line, "displacement_x"), columns.number(line, "displacement_y")},
                          {columns.number(line, "force_x"), columns.number(line, "force_y")}});
    }
    if (columns.empty()) throw FileError(fmt::format("{}: has no header", file));
    if (all.empty()) throw FileError(fmt::format("{}: has no rows", file));
    return all;
}

History history_of(const std::string& file, const Rows& h, const Outline& outline, double tolerance_m, double size_m) {
    const double arc = outline.arc_of(h.contact_m), off = (outline.position(arc) - h.contact_m).norm();
    if (!(off <= tolerance_m)) refuse(file, h, fmt::format("has a contact {} off the free surface; allowed: {:g} mm", length_text(off), 1e3 * tolerance_m));
    if (arc < apart_m || arc > outline.length() - apart_m) refuse(file, h, "has a contact within 2 mm of the fixed edge");
    if (h.rows.size() < least_rows) refuse(file, h, fmt::format("has {} rows, at least {} are needed", h.rows.size(), least_rows));
    History out;
    out.name = h.name;
    out.kind = h.kind.empty() ? "measured" : h.kind;
    out.group = out.kind;
    out.role = h.role;
    out.contact_m = outline.position(arc);
    const auto T = static_cast<Eigen::Index>(h.rows.size());
    out.time_s.resize(T);
    out.push_m.resize(T, 2);
    out.force_N.resize(T, 2);
    out.contact.assign(h.rows.size(), 1);
    for (Eigen::Index n = 0; n < T; ++n) {
        const Row& row = h.rows[static_cast<std::size_t>(n)];
        out.time_s[n] = row.time_s - h.rows.front().time_s;
        out.push_m.row(n) = row.push_m.transpose();
        out.force_N.row(n) = row.force_N.transpose();
    }
    Eigen::Index deepest = 0;
    const double depth_m = out.push_m.rowwise().norm().maxCoeff(&deepest);
    if (!(depth_m > 0) || !(out.force_N.squaredNorm() > 0)) refuse(file, h, "has no displacement, or no force");
    if (depth_m > size_m) refuse(file, h, fmt::format("has a displacement of {}, more than the tissue's size of {}", length_text(depth_m), length_text(size_m)));
    if (!(out.push_m.row(0).norm() <= at_rest * depth_m)) refuse(file, h, fmt::format("begins at a displacement of {:.3g} mm: it must begin at rest", 1e3 * out.push_m.row(0).norm()));
    out.push_m.row(0).setZero();
    out.direction = out.push_m.row(deepest).transpose().normalized();
    if (std::abs(outline.angle(arc, Eigen::Vector2d(out.direction))) >= 1.5707963267948966) refuse(file, h, "has a displacement out of the tissue");
    if (!(out.force_N.row(deepest).dot(out.push_m.row(deepest)) > 0)) refuse(file, h, "has a force against its largest displacement; give the tool's force on the tissue");
    return out;
}

/// Groups the histories by contact, sorted along the surface and split wherever neighbours are 2 mm or more apart.
std::vector<std::vector<History*>> contacts_of(std::vector<History>& histories, const Outline& outline) {
    std::vector<History*> sorted;
    for (History& h : histories) sorted.push_back(&h);
    const auto arc = [&](const History* h) { return outline.arc_of(Eigen::Vector2d(h->contact_m)); };
    std::stable_sort(sorted.begin(), sorted.end(), [&](const History* a, const History* b) { return arc(a) < arc(b); });
    std::vector<std::vector<History*>> contacts;
    for (History* h : sorted) {
        if (contacts.empty() || arc(h) - arc(contacts.back().back()) >= apart_m) contacts.emplace_back();
        contacts.back().push_back(h);
    }
    return contacts;
}

/// Checks the file's own roles: histories of the test or validation set may not be near those that relative moduli are
/// fitted to. first: the first history of the file. read (H): the histories as they were read, for their lines.
void check_roles(const std::vector<std::vector<History*>>& contacts, const History* first, const std::vector<Rows>& read, const std::string& file) {
    for (const std::vector<History*>& contact : contacts)
        for (std::size_t i = 1; i < contact.size(); ++i) {
            // in the order of the file
            const History *before = std::min(contact[i - 1], contact[i]), *after = std::max(contact[i - 1], contact[i]);
            if ((before->role == "train") != (after->role == "train"))
                refuse(file, read[static_cast<std::size_t>(after - first)],
                       fmt::format("is '{}', less than 2 mm along the surface from '{}' of line {}, which is '{}'; the test set and the training set must be apart", after->role,
                                   before->name, read[static_cast<std::size_t>(before - first)].line, before->role));
        }
}

/// Draws the role of each history by the study's seed. Contacts less than 2 mm apart get the same role.
void draw_roles(const std::vector<std::vector<History*>>& contacts, const Study::Data& data, const std::string& file) {
    if (contacts.size() < 2) throw FileError(fmt::format("{}: has histories at only one contact: a test set needs a second contact, or a column 'role'", file));
    const Rng rng = seeded_rng(data.seed);
    std::vector<std::size_t> order(contacts.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    gsl_ran_shuffle(rng.get(), order.data(), order.size(), sizeof order[0]);
    const auto part = [&](double p) { return p > 0 ? static_cast<std::size_t>(std::max(1L, std::lround(p * static_cast<double>(contacts.size())))) : 0; };
    const std::size_t proof = std::min(part(data.held_out_part), contacts.size() - 1), choice = std::min(part(data.validation_part), contacts.size() - 1 - proof);
    for (std::size_t k = 0; k < contacts.size(); ++k)
        for (History* h : contacts[order[k]]) h->role = k < proof ? "held_out" : k < proof + choice ? "validation" : "train";
}

}  // namespace

std::vector<History> read_measured_histories(const Study& study, const std::string& file) {
    const std::vector<Rows> read = read_rows(file);
    const SpringMesh mesh = study_mesh(study, std::nullopt, study.springs.topology);
    const Outline outline(mesh);
    std::vector<History> histories;
    for (const Rows& h : read) histories.push_back(history_of(file, h, outline, study.data->surface_tolerance_m, mesh.size_m()));
    const std::vector<std::vector<History*>> contacts = contacts_of(histories, outline);
    if (read.front().role.empty())
        draw_roles(contacts, *study.data, file);
    else
        check_roles(contacts, histories.data(), read, file);
    const auto none = [&](const char* role) { return std::none_of(histories.begin(), histories.end(), [&](const History& h) { return h.role == role; }); };
    if (none("train")) throw FileError(fmt::format("{}: has no history of role 'train', which the fit of relative moduli needs", file));
    if (none("held_out")) throw FileError(fmt::format("{}: has no history of role 'held_out', which the evaluation needs", file));
    return histories;
}

}  // namespace tissue
