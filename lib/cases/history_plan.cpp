#include "cases/history_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cases/solid_draws.h"
#include "cases/solid_training.h"
#include "cases/study_mesh.h"
#include "cases/surface_contacts.h"
#include "error.h"
#include "io/one_line.h"
#include "study/solid_push.h"

namespace tissue {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;
// Time between the two touches of kind "again". By then the released tissue no longer oscillates, but a good part of
// the imprint is left.
constexpr double away_s = 0.8;

/// Random draws of a group's histories: contacts, directions and numbers. Derived for the plane and for space.
class Begun {
   public:
    virtual ~Begun() = default;
    /// Draws the next contact: fills push, and second_contact_m where the group has one.
    virtual void next(PlannedHistory& history) = 0;
    virtual double uniform(double low, double high) = 0;
    virtual Point strayed() = 0;                 ///< a unit vector, drawn up to wander_deg from the contact's direction
    virtual Point second_direction() const = 0;  ///< unit vector of the second touch
};

std::string key_of(const Study::Histories& group) {
    return "histories '" + group.name + "'";
}

class BegunInPlane : public Begun {
   public:
    BegunInPlane(const Study& study, const Study::Histories& group, const Outline& outline, const std::vector<SurfaceContact>& trained)
        : group_(group), outline_(outline), draws_(study, group, outline, trained, key_of(group)) {}

    void next(PlannedHistory& history) override {
        const bool elsewhere = group_.kind == "again" && group_.apart_m > 0;
        if (elsewhere) {
            const std::array<SurfaceContact, 2> both = draws_.pair(group_.apart_m);
            contact_ = both[0];
            second_ = both[1];
            history.second_contact_m = outline_.position(second_.arc);
        } else {
            contact_ = second_ = draws_.contact();
        }
        history.push.contact_m = outline_.position(contact_.arc);
        history.push.direction = outline_.direction(contact_.arc, contact_.angle);
        history.push.depth_m = uniform(group_.depth_m[0], group_.depth_m[1]);
    }
    double uniform(double low, double high) override { return draws_.uniform(low, high); }
    Point strayed() override {
        return outline_.direction(contact_.arc, contact_.angle + uniform(-group_.wander_deg, group_.wander_deg) * degree);
    }
    Point second_direction() const override { return outline_.direction(second_.arc, second_.angle); }

   private:
    const Study::Histories& group_;
    const Outline& outline_;
    ContactDraws draws_;
    SurfaceContact contact_{}, second_{};
};

class BegunInSpace : public Begun {
   public:
    BegunInSpace(const Study& study, const Study::Histories& group, const std::vector<StudyPath>& trained, const FreeSurface* surface)
        : group_(group), draws_(study, group, trained, surface, key_of(group)) {}

    void next(PlannedHistory& history) override {
        history.push = draws_.push();
        direction_ = history.push.direction;
    }
    double uniform(double low, double high) override { return draws_.uniform(low, high); }
    /// Uniform in solid angle, as the tilts of draws are.
    Point strayed() override {
        const double off_deg = std::acos(uniform(std::cos(group_.wander_deg * degree), 1)) / degree;
        return surface_push(direction_, std::min(off_deg, group_.wander_deg), uniform(0, 360));
    }
    Point second_direction() const override { return direction_; }

   private:
    const Study::Histories& group_;
    SolidDraws draws_;
    Point direction_;
};

double log_uniform(Begun& begun, const double (&range)[2]) {
    return std::clamp(std::exp(begun.uniform(std::log(range[0]), std::log(range[1]))), range[0], range[1]);
}

Trajectory drawn_trajectory(Begun& begun, const Study::Histories& group, const StudyPath& push) {
    TrajectoryBuilder trajectory(push.contact_m.size());
    const Point deep_m = push.depth_m * push.direction;
    if (group.kind == "sine") {
        trajectory.sine(deep_m, log_uniform(begun, group.frequency_Hz), group.duration_s);
        return trajectory.trajectory();
    }
    const double rise_s = log_uniform(begun, group.rise_s);
    trajectory.stroke(deep_m, rise_s);
    if (group.kind == "poke") {
        while (trajectory.time_s() < group.duration_s) {
            const Point direction = begun.strayed();
            const double depth_m = begun.uniform(group.depth_m[0], group.depth_m[1]);
            trajectory.stroke(depth_m * direction, log_uniform(begun, group.rise_s));
        }
        return trajectory.trajectory();
    }
    trajectory.hold(group.hold_s);
    if (group.kind == "release") {
        trajectory.stroke(Point::Zero(deep_m.size()), rise_s);
        trajectory.hold(group.hold_s);
    } else if (group.kind == "again") {
        trajectory.away(away_s);
        trajectory.touch(group.apart_m > 0 ? 2 : 1);
        trajectory.stroke(push.depth_m * begun.second_direction(), rise_s);
        trajectory.hold(group.hold_s);
    }
    return trajectory.trajectory();
}

[[noreturn]] void refuse_place(const Study& study, const Study::Histories& group, const std::string& why) {
    throw StudyError(one_line(fmt::format("{}: key 'contact_m' of {}: {}", study.file, key_of(group), why)));
}

/// The contact of a trajectory from a file, on the surface.
Point listed_contact(const Study& study, const std::optional<Shape>& shape, const Study::Histories& group) {
    const Point& at = group.contact_m;
    if (study.geometry.is_block()) return at;
    if (study.geometry.is_solid()) {
        const FreeSurface surface = study_surface(study, shape);
        const FreeSurface::Place place = surface.nearest(at);
        if (place.distance_m > surface.spacing_m()) refuse_place(study, group, fmt::format("is {:.3g} mm off the free surface", 1e3 * place.distance_m));
        if (surface.clearance_m(place.point_m) < study.indenter.clearance_m())
            refuse_place(study, group, fmt::format("is {:.3g} mm from where the free surface ends or turns; a disc needs {:g} mm",
                                                   1e3 * surface.clearance_m(place.point_m), 1e3 * study.indenter.clearance_m()));
        return place.point_m;
    }
    constexpr double tiny_m = 1e-9;
    const double clearance_m = study.indenter.clearance_m();
    const Outline outline(study_mesh(study, shape, "edges"));
    const double arc = outline.arc_of(at), off_m = (outline.position(arc) - at).norm(),
                 spacing_m = outline.length() / static_cast<double>(outline.nodes().size() - 1);
    if (off_m > spacing_m) refuse_place(study, group, fmt::format("is {:.3g} mm off the free surface", 1e3 * off_m));
    if (arc < clearance_m - tiny_m || arc > outline.length() - clearance_m + tiny_m)
        refuse_place(study, group, fmt::format("is nearer than {:g} mm to the fixed edge", 1e3 * clearance_m));
    return outline.position(arc);
}

PlannedHistory listed(const Study& study, const std::optional<Shape>& shape, const Study::Histories& group) {
    PlannedHistory history;
    history.push.contact_m = listed_contact(study, shape, group);
    history.push.radius_m = study.indenter.radius_m;
    history.trajectory = read_trajectory(group.file, history.push.contact_m.size());
    Eigen::Index deepest = 0;
    history.push.depth_m = history.trajectory.push_m.rowwise().norm().maxCoeff(&deepest);
    history.push.direction = history.trajectory.push_m.row(deepest).transpose().normalized();
    return history;
}

}  // namespace

std::vector<PlannedHistory> planned_histories(const Study& study, const std::optional<Shape>& shape) {
    std::vector<PlannedHistory> histories;
    if (study.histories.empty()) return histories;
    const bool solid = study.geometry.is_solid();
    std::optional<Outline> outline;
    std::vector<SurfaceContact> trained;
    std::optional<FreeSurface> surface;
    std::vector<StudyPath> trained_in_space;
    if (solid) {
        trained_in_space = solid_training(study, shape);
        if (!study.geometry.is_block()) surface.emplace(study_surface(study, shape));
    } else if (study.loads.sweep) {
        outline.emplace(study_mesh(study, shape, "edges"));
        trained = training_contacts(*outline, *study.loads.sweep, study.geometry.is_block());
    }
    for (const Study::Histories& group : study.histories) {
        std::unique_ptr<Begun> begun;
        if (group.file.empty() && solid) begun = std::make_unique<BegunInSpace>(study, group, trained_in_space, surface ? &*surface : nullptr);
        if (group.file.empty() && !solid) begun = std::make_unique<BegunInPlane>(study, group, *outline, trained);
        for (int i = 1; i <= group.count; ++i) {
            PlannedHistory history;
            if (begun) {
                begun->next(history);
                history.trajectory = drawn_trajectory(*begun, group, history.push);
                history.push.depth_m = history.trajectory.depth_m();
            } else {
                history = listed(study, shape, group);
            }
            history.push.name = fmt::format("{}-{:04}", group.name, i);
            history.group = group.name;
            history.kind = group.kind;
            history.role = group.role;
            histories.push_back(std::move(history));
        }
    }
    return histories;
}

}  // namespace tissue
