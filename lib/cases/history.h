#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "field.h"

namespace tissue {

struct PlannedHistory;

/// What finite elements said of one course of the tool in time: T rows, one a step, the first at time 0 and rest.
struct History {
    std::string name;                 ///< "ramp-0001"
    std::string group, kind, role;    ///< as in Study::Histories
    Point contact_m;                  ///< at rest (D)
    Point direction;                  ///< unit vector of the first stroke (D)
    std::optional<Point> second_contact_m;  ///< where the tool touches again (D), where that is another place
    Eigen::VectorXd time_s;           ///< (T), ascending
    NodeField push_m;                 ///< displacement of the tool from the contact that it touches, at rest (T x D); 0 while it is away
    NodeField force_N;                ///< of the tool on the tissue (T x D)
    NodeField elastic_N;              ///< the same on tissue that does not relax (T x D); 0 rows where FE lost that, or none was asked for
    std::vector<int> contact;         ///< (T) 0: the tool is away; 1: at its contact; 2: at the second one
    std::string lost;                 ///< why FE ended before the course did; empty when it did not
};

/// Reads FreeFEM's CSV of one history (results/FORMATS.md), of version 1, in which the tool never is away, or 2: times, pushes, forces,
/// contact and `lost`. Throws FileError with file, line and cause: missing, truncated, a number that is none, times that do not
/// ascend from 0.
History read_history_csv(const std::string& file, Eigen::Index dimension);

/// A planned history as FE's CSVs in a folder say it, with the elastic one beside it where `relaxes`. Throws FileError as
/// read_history_csv, and where the elastic tool went another way.
History read_planned_history(const PlannedHistory& planned, const std::string& folder, bool relaxes);

}  // namespace tissue
