#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "cases/trajectory.h"
#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// One displacement history of the tool that finite elements are to solve.
struct PlannedHistory {
    /// Name ("ramp-0001"), contact, direction of the first ramp (for a file of the largest displacement), largest
    /// depth.
    StudyPath push;
    std::string group, kind, role;  ///< as in Study::Histories
    std::optional<Point> second_contact_m;  ///< where the tool touches again; none where that is the first contact
    Trajectory trajectory;

    /// Whether the same history is solved on elastic tissue too: where the tissue relaxes and the tool is never away. A
    /// tool that lands again takes the surface as it is then, so its displacement would differ on elastic tissue.
    bool has_elastic(const Study& study) const {
        return study.material.relaxes() && std::find(trajectory.contact.begin(), trajectory.contact.end(), 0) == trajectory.contact.end();
    }
    /// Name of the history on elastic tissue.
    std::string elastic_name() const { return push.name + "-elastic"; }
};

/// All histories of a study, group by group, drawn before any of them is solved. Each group has its own random stream.
/// Its drawn contacts are 2 mm or 5 degrees from every training contact.
/// Throws MismatchError when a draw finds no such contact; StudyError where the contact of a file is off the surface of
/// a shape or too near to where it ends; FileError as read_trajectory.
std::vector<PlannedHistory> planned_histories(const Study& study, const std::optional<Shape>& shape = {});

}  // namespace tissue
