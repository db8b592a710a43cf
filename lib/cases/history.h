#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "field.h"

namespace tissue {

struct PlannedHistory;

/// FE reference, or measurement, of one displacement history of the tool: T rows, one a step, the first at time 0 and
/// rest.
struct History {
    std::string name;                 ///< "ramp-0001"
    std::string group, kind, role;    ///< as in Study::Histories
    Point contact_m;                  ///< at rest (D)
    /// Unit vector of the first ramp; for a file or a measurement of the largest displacement (D).
    Point direction;
    std::optional<Point> second_contact_m;  ///< where the tool touches again (D); none where that is the first contact
    Eigen::VectorXd time_s;           ///< (T), ascending
    /// Displacement of the tool from its contact at rest (T x D), as FE prescribed it or as measured; 0 while the tool
    /// is away. FE's differs from the planned one where the tool lands on tissue that still oscillates or creeps.
    NodeField push_m;
    NodeField force_N;                ///< of the tool on the tissue (T x D)
    /// Force of the same history on tissue that does not relax (T x D); 0 rows where FE did not finish it or was not to
    /// solve it.
    NodeField elastic_N;
    std::vector<int> contact;         ///< (T) 0: the tool is away; 1: at its contact; 2: at the second one
    std::string lost;                 ///< cause, where FE ended before the last step; else empty
};

/// Reads FreeFEM's CSV of one history (results/FORMATS.md): times, displacements, forces, contact and `lost`. In
/// version 1 the tool is never away, version 2 has a column for the contact. Throws FileError with file, line and
/// cause: missing, truncated, a field that is no number, times that do not ascend from 0.
History read_history_csv(const std::string& file, Eigen::Index dimension);

/// Reads a planned history from FE's CSVs in a folder, with the elastic one where `has_elastic`. Throws FileError as
/// read_history_csv, and where the elastic one has other times or contacts.
History read_planned_history(const PlannedHistory& planned, const std::string& folder, bool has_elastic);

}  // namespace tissue
