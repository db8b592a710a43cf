#include "cases/histories_file.h"
#include "io/one_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Values contact_number() {
    Values v = Values::count();
    v.high = 2;
    return v;
}

/// One text for each history.
template <class Value>
std::vector<std::string> texts_of(const std::vector<History>& histories, const Value& value) {
    std::vector<std::string> texts;
    for (const History& h : histories) texts.push_back(value(h));
    return texts;
}

/// One row for each history.
template <class Value>
NodeField rows_of(const std::vector<History>& histories, Eigen::Index D, const Value& value) {
    NodeField rows(static_cast<Eigen::Index>(histories.size()), D);
    for (std::size_t h = 0; h < histories.size(); ++h) rows.row(static_cast<Eigen::Index>(h)) = value(histories[h]).transpose();
    return rows;
}

/// All rows of a field, one history after the other.
template <class Value>
NodeField joined_of(const std::vector<History>& histories, Eigen::Index D, Eigen::Index total, const Value& value) {
    NodeField all(total, D);
    Eigen::Index at = 0;
    for (const History& h : histories) {
        all.middleRows(at, h.time_s.size()) = value(h);
        at += h.time_s.size();
    }
    return all;
}

}  // namespace

const DatasetTable& histories_table() {
    static const DatasetTable table = {
        {"/histories/name", "H", Values::names(), "text", "displacement histories, in the study's order"},
        {"/histories/group", "H", Values::text(), "text", "group of each in the study"},
        {"/histories/kind", "H", Values::text(), "text", "kind of motion: ramp, release, sine, poke, again, file"},
        {"/histories/role", "H", Values::text(), "text", "role of each"},
        {"/histories/lost", "H", Values::text(), "text", "why FE ended before the history did, if so"},
        {"/histories/contact_place", "H x D", Values::place(), "m", "contact at rest"},
        {"/histories/second_place", "H x D", Values::place().or_nan(), "m", "second contact at rest; NaN where there is none"},
        {"/histories/direction", "H x D", Values::finite(), "1", "unit vector of the first displacement", Rows::unit},
        {"/histories/offset", "O", Values::count(), "1", "first row of each history, then the number of rows"},
        {"/histories/time", "K*", Values::not_negative(), "s", "time, from 0 in each"},
        {"/histories/push", "K* x D", Values::place(), "m", "displacement of the tool from the contact that it touches"},
        {"/histories/contact", "K*", contact_number(), "1", "0: the tool is off the tissue, 1: at its contact, 2: at the second contact"},
        {"/histories/force", "K* x D", Values::finite(), "N", "force of the tool on the tissue"},
        {"/histories/elastic_force", "K* x D", Values::finite().or_nan(), "N", "force of the tool on tissue that does not relax; NaN where there is none"},
    };
    return table;
}

void write_histories(TableWriter& out, const std::vector<History>& histories, Eigen::Index dimension) {
    std::vector<int> offset = {0}, contact;
    for (const History& h : histories) {
        offset.push_back(offset.back() + static_cast<int>(h.time_s.size()));
        contact.insert(contact.end(), h.contact.begin(), h.contact.end());
    }
    const Eigen::Index total = offset.back();
    Eigen::VectorXd time(total);
    for (std::size_t h = 0; h < histories.size(); ++h) time.segment(offset[h], histories[h].time_s.size()) = histories[h].time_s;
    out.write_texts("/histories/name", texts_of(histories, [](const History& h) { return h.name; }));
    out.write_texts("/histories/group", texts_of(histories, [](const History& h) { return h.group; }));
    out.write_texts("/histories/kind", texts_of(histories, [](const History& h) { return h.kind; }));
    out.write_texts("/histories/role", texts_of(histories, [](const History& h) { return h.role; }));
    out.write_texts("/histories/lost", texts_of(histories, [](const History& h) { return h.lost; }));
    const Point nowhere = Point::Constant(dimension, nan);
    out.write("/histories/contact_place", rows_of(histories, dimension, [](const History& h) { return h.contact_m; }));
    out.write("/histories/second_place", rows_of(histories, dimension, [&](const History& h) { return h.second_contact_m.value_or(nowhere); }));
    out.write("/histories/direction", rows_of(histories, dimension, [](const History& h) { return h.direction; }));
    out.write_integers("/histories/offset", {offset.size()}, offset);
    out.write("/histories/time", time);
    out.write("/histories/push", joined_of(histories, dimension, total, [](const History& h) -> const NodeField& { return h.push_m; }));
    out.write_integers("/histories/contact", {contact.size()}, contact);
    out.write("/histories/force", joined_of(histories, dimension, total, [](const History& h) -> const NodeField& { return h.force_N; }));
    out.write("/histories/elastic_force", joined_of(histories, dimension, total, [&](const History& h) -> NodeField {
                  return h.elastic_N.rows() > 0 ? h.elastic_N : NodeField::Constant(h.time_s.size(), dimension, nan);
              }));
}

std::vector<History> read_histories(TableReader& in) {
    const std::vector<std::string> name = in.texts("/histories/name"), group = in.texts("/histories/group"), kind = in.texts("/histories/kind"),
                                   role = in.texts("/histories/role"), lost = in.texts("/histories/lost");
    const NodeField place = in.field("/histories/contact_place"), second = in.field("/histories/second_place"),
                    direction = in.field("/histories/direction");
    const std::vector<int> offset = in.integers("/histories/offset");
    const Eigen::VectorXd time = in.vector("/histories/time");
    const NodeField push = in.field("/histories/push"), force = in.field("/histories/force"), elastic = in.field("/histories/elastic_force");
    const std::vector<int> contact = in.integers("/histories/contact");
    if (offset.size() != name.size() + 1 || offset.front() != 0 || offset.back() != time.size() || !std::is_sorted(offset.begin(), offset.end()))
        in.refuse("/histories/offset", fmt::format("does not divide {} rows into {} histories", time.size(), name.size()));
    std::vector<History> histories;
    for (std::size_t i = 0; i < name.size(); ++i) {
        const Eigen::Index row = static_cast<Eigen::Index>(i), begin = offset[i], T = offset[i + 1] - offset[i];
        History h;
        h.name = name[i];
        h.group = group[i];
        h.kind = kind[i];
        h.role = role[i];
        h.lost = one_line(lost[i]);
        h.contact_m = place.row(row).transpose();
        h.direction = direction.row(row).transpose();
        if (second.row(row).array().isNaN().any() && !second.row(row).array().isNaN().all())
            in.refuse("/histories/second_place", fmt::format("row {} has some numbers that are NaN and some that are not", i));
        if (!std::isnan(second(row, 0))) h.second_contact_m = second.row(row).transpose();
        h.time_s = time.segment(begin, T);
        if (T == 0 && h.lost.empty()) in.refuse("/histories/offset", "'" + h.name + "' has no rows and no reason in /histories/lost");
        for (Eigen::Index t = 0; t < T; ++t)
            if (t == 0 ? h.time_s[0] != 0 : !(h.time_s[t] > h.time_s[t - 1]))
                in.refuse("/histories/time", fmt::format("row {} of '{}' does not ascend from 0", t, h.name));
        h.push_m = push.middleRows(begin, T);
        h.force_N = force.middleRows(begin, T);
        const auto own = elastic.middleRows(begin, T);
        const bool none = own.array().isNaN().any();
        if (none && !own.array().isNaN().all()) in.refuse("/histories/elastic_force", "'" + h.name + "' has some numbers that are NaN and some that are not");
        h.elastic_N = none ? NodeField(0, push.cols()) : NodeField(own);
        h.contact.assign(contact.begin() + begin, contact.begin() + begin + T);
        if (!h.second_contact_m && std::count(h.contact.begin(), h.contact.end(), 2) > 0)
            in.refuse("/histories/contact", "'" + h.name + "' has contact 2, and no second place");
        histories.push_back(std::move(h));
    }
    return histories;
}

}  // namespace tissue
