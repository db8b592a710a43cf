#include "cases/history.h"

#include <fmt/format.h>

#include "cases/history_plan.h"
#include "cases/path_lines.h"
#include "error.h"

namespace tissue {
namespace {

constexpr int contact_version = 2;  ///< first format version with a column for the contact

}  // namespace

History read_history_csv(const std::string& file, Eigen::Index dimension) {
    PathLines line(file);
    const auto D = static_cast<std::size_t>(dimension);
    // where FreeFEM cannot place the contact, the file has the header of a load path and only a `lost` row
    bool unplaced = false;
    if (line.next()) unplaced = line.kind() == "tissuectl load path";
    if (line.kind() != "tissuectl history" && !unplaced) line.refuse("is not a tissuectl history");
    line.want(2);
    const double version = line.number(1);
    if (unplaced ? version != 1 : version != 1 && version != contact_version) line.refuse("has another format version; this program reads 1 and 2");
    const std::size_t contacts = version == contact_version ? 1 : 0, fields = 6 + 3 * D + contacts;

    History history;
    std::vector<double> time;
    std::vector<Point> push, force;
    bool ended = false;
    while (line.next()) {
        if (ended) line.refuse("follows the end row");
        if (line.kind() == "step" && !unplaced) {
            line.want(fields);
            if (line.number(1) != static_cast<double>(time.size())) line.refuse(fmt::format("step {} is missing", time.size()));
            const double at = line.number(2);
            if (time.empty() ? at != 0 : !(at > time.back())) line.refuse("the times must ascend from 0");
            const double contact = contacts > 0 ? line.number(3 + D) : 1;
            if (contact != 0 && contact != 1 && contact != 2) line.refuse(fmt::format("contact is {:g}, must be 0, 1 or 2", contact));
            time.push_back(at);
            push.push_back(line.point(3, D));
            history.contact.push_back(static_cast<int>(contact));
            force.push_back(line.point(3 + D + contacts, D));
            for (std::size_t i = 3 + 2 * D + contacts; i < fields; ++i) line.number(i);
        } else if (line.kind() == "node" && !time.empty()) {  // nodal rows are allowed and not used
            line.want(1 + 3 * D);
        } else if (line.kind() == "end" && !unplaced) {
            line.want(2);
            if (line.number(1) != static_cast<double>(time.size())) line.refuse("steps are missing");
            ended = true;
        } else if (line.kind() == "lost") {
            line.want_at_least(3);
            if (line.number(1) != static_cast<double>(time.size())) line.refuse("steps are missing");
            history.lost = line.text_from(2);
            ended = true;
        } else {
            line.refuse("is not a step, node, end or lost row");
        }
    }
    if (!ended) line.refuse("the file is truncated: it has no end row");
    const auto T = static_cast<Eigen::Index>(time.size());
    history.time_s = Eigen::Map<const Eigen::VectorXd>(time.data(), T);
    history.push_m.resize(T, dimension);
    history.force_N.resize(T, dimension);
    history.elastic_N.resize(0, dimension);
    for (Eigen::Index t = 0; t < T; ++t) {
        history.push_m.row(t) = push[static_cast<std::size_t>(t)].transpose();
        history.force_N.row(t) = force[static_cast<std::size_t>(t)].transpose();
    }
    return history;
}

History read_planned_history(const PlannedHistory& planned, const std::string& folder, bool has_elastic) {
    const Eigen::Index D = planned.push.contact_m.size();
    History history = read_history_csv(folder + "/" + planned.push.name + ".csv", D);
    history.name = planned.push.name;
    history.group = planned.group;
    history.kind = planned.kind;
    history.role = planned.role;
    history.contact_m = planned.push.contact_m;
    history.direction = planned.push.direction;
    history.second_contact_m = planned.second_contact_m;
    if (!has_elastic) return history;
    const std::string file = folder + "/" + planned.elastic_name() + ".csv";
    const History elastic = read_history_csv(file, D);
    const Eigen::Index T = history.time_s.size(), both = std::min(T, elastic.time_s.size());
    if (history.lost.empty() && elastic.lost.empty() && elastic.time_s.size() != T)
        throw FileError(fmt::format("{}: has {} steps, {} has {}", file, elastic.time_s.size(), history.name, T));
    for (Eigen::Index t = 0; t < both; ++t)
        if (elastic.time_s[t] != history.time_s[t] || elastic.contact[static_cast<std::size_t>(t)] != history.contact[static_cast<std::size_t>(t)])
            throw FileError(fmt::format("{}: step {} has another time or contact than in {}: both must have the same displacement history", file, t, history.name));
    if (elastic.lost.empty() && both == T) history.elastic_N = elastic.force_N.topRows(T);
    return history;
}

}  // namespace tissue
