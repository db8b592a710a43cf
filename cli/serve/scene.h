#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lesson.h"
#include "fe_outline.h"
#include "known_errors.h"
#include "haptic/state_channel.h"
#include "mesh/carried_points.h"
#include "mesh/carried_surface.h"
#include "mesh/free_surface.h"
#include "springs/tissue_model.h"

namespace tissue::serve {

/// A place with an FE reference: the model's load cases with one contact and one direction.
struct Place {
    std::string name;
    Point contact_m, direction, inward;            ///< on the trained mesh at rest; unit vectors (D)
    double depth_m = 0;                            ///< of the deepest case
    /// depth [m], FE force along the tool displacement [N], from 0; may be empty
    std::vector<std::pair<double, double>> curve;
    std::vector<FeOutline> outlines;               ///< FE surface by depth, from rest; may be empty
};

/// The place with an FE reference that is nearest to a contact.
struct Near {
    int place = -1;
    double distance_m = 0;
    double force_N;         ///< FE force along the tool displacement, at the trained mesh's depth; NaN: not known
};

/// A point of a mesh's free surface at rest, and the unit normal into the tissue there (D).
struct Touch {
    Point contact_m, inward;
};

/// Constant data of a model, in the plane or in space, for a page and for the hand that indents it.
class Scene {
   public:
    using Box = std::pair<Point, Point>;   ///< low, high (D)

    /// fe_displacement_m: FE displacements of every node at each load case, (C) of (N x D); or empty. learned: field of
    /// an adapted model; nullopt of others.
    Scene(const TissueModel& tissue, const HapticModel& model, const std::vector<NodeField>& fe_displacement_m = {}, std::optional<LearnedField> learned = {});

    const std::vector<Place>& places() const { return places_; }
    int first_place() const { return first_; }     ///< where the demo starts: near the middle of the top, straight in
    const HapticModel& model() const { return model_; }
    const SpringMesh& mesh() const { return mesh_; }
    int dimension() const { return model_.dimension(); }
    bool learns() const { return model_.options.stiffest > 1; }   ///< whether the model adapts during the session
    bool relaxes() const { return tau_s_.size() > 0; }

    /// Boxes of every mesh at rest.
    const std::vector<Box>& boxes() const { return boxes_; }

    /// Nodes that are sent to a page, ascending: in the plane all; in space those of the boundary and those that carry
    /// the nodule.
    const std::vector<int>& shown() const { return shown_; }

    /// Point of the free surface of any mesh at rest that is nearest to p.
    Touch nearest(const Point& p) const;

    Near near(const TickState& state) const;

    /// Whether a node is farther from rest than 0.3 of the node spacing, as in a mesh that settled in an inverted
    /// equilibrium. Call for tissue that was not touched for a while; oscillations have then decayed below that.
    bool away_from_rest(const TickState& state) const;

    /// Sets a finer surface that the page draws in place of the model's boundary.
    void carry(const CarriedSurface& surface);

    /// That surface in the bytes that a page fetches (cli/view/PROTOCOL.md, `surface`); empty where there is none.
    const std::string& carried() const { return carried_; }

    /// Sets the errors of a model in space against the FE reference.
    void know(std::vector<ReferenceError> errors);

    /// Sets the field of a model that adapts during the session.
    void learn(LearnedField field) { learned_ = std::move(field); }

    /// The message of type `learned` (cli/view/PROTOCOL.md), with the field that learn() has set.
    std::string message(const Lesson::News& news) const;

    /// The message of type `model` (cli/view/PROTOCOL.md). names: of all models served; index: of this model.
    std::string message(const std::vector<std::string>& names, int index) const;

   private:
    const HapticModel& model_;
    SpringMesh mesh_;
    FreeSurface surface_;
    /// relaxation times [s] and relative moduli of the contact (K); empty for a model that does not relax
    Eigen::VectorXd tau_s_, contact_share_;
    std::optional<LearnedField> learned_;
    std::vector<int> shown_;
    NoduleSurface nodule_;
    CarriedPoints nodule_carried_;
    std::vector<ReferenceError> errors_;
    std::string carried_;
    std::vector<Place> places_;
    std::vector<Box> boxes_;
    int first_ = 0;
};

}  // namespace tissue::serve
