#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cases/course.h"
#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// One course of the tool that finite elements are to follow in time.
struct PlannedHistory {
    StudyPath push;  ///< name ("ramp-0001"), contact, direction of the first stroke, how far from rest the tool goes at most
    std::string group, kind, role;  ///< as in Study::Histories
    std::optional<Point> second_contact_m;  ///< where the tool touches again, where that is another place
    Course course;

    /// Name of the same course on tissue that does not relax.
    std::string elastic_name() const { return push.name + "-elastic"; }
};

/// Every course of a study's histories, group by group, all drawn before any of them is solved. A group's contacts and all else are drawn
/// by a stream of its own, and its contacts keep 2 mm or 5 degrees from every training contact.
/// Throws MismatchError when a draw finds no such contact; StudyError for a file's contact that is off the surface of a shape; FileError
/// as read_course.
std::vector<PlannedHistory> planned_histories(const Study& study, const std::optional<Shape>& shape = {});

}  // namespace tissue
