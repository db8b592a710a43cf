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

/// One place where the model knows finite elements' answer: its load cases with one contact and one direction.
struct Place {
    std::string name;
    Point contact_m, direction, inward;            ///< learned mesh at rest; unit vectors (D)
    double depth_m = 0;                            ///< deepest case
    std::vector<std::pair<double, double>> curve;  ///< depth [m], FE force along the push [N], from 0; or empty
    std::vector<FeOutline> outlines;               ///< FE's surface by depth, from rest; or empty
};

/// The known place that is nearest to a contact.
struct Near {
    int place = -1;
    double distance_m = 0;
    double force_N;         ///< FE's at the learned mesh's depth, along the push; NaN when unknown
};

/// A point of a mesh's free surface at rest, and the unit normal into the tissue there (D).
struct Touch {
    Point contact_m, inward;
};

/// What a model looks like to a page, and to the hand that presses it, in the plane or in space. Constants only.
class Scene {
   public:
    using Box = std::pair<Point, Point>;   ///< low, high (D)

    /// fe_displacement_m: FE's, of every node at each load case (C) of (N x D), or empty.
    /// learned: of pokes, where the model has.
    Scene(const TissueModel& tissue, const HapticModel& model, const std::vector<NodeField>& fe_displacement_m = {}, std::optional<LearnedField> learned = {});

    const std::vector<Place>& places() const { return places_; }
    int first_place() const { return first_; }     ///< where the demo begins: the middle of the top, straight in
    const HapticModel& model() const { return model_; }
    const SpringMesh& mesh() const { return mesh_; }
    int dimension() const { return model_.dimension(); }
    bool learns() const { return model_.options.stiffest > 1; }   ///< while it plays
    bool relaxes() const { return tau_s_.size() > 0; }

    /// Boxes of every mesh at rest.
    const std::vector<Box>& boxes() const { return boxes_; }

    /// Nodes that a page is told, ascending: in the plane all, in space those of the boundary and those that carry the nodule.
    const std::vector<int>& shown() const { return shown_; }

    /// Where the free surface of any mesh at rest is nearest to a point.
    Touch nearest(const Point& p) const;

    Near near(const TickState& state) const;

    /// Whether a node of a mesh is farther from rest than 0.3 of the nodes' distance: a mesh that was drawn through itself and stays so.
    /// Asked of tissue that nothing has touched for a while; what still swings then is nearer.
    bool away_from_rest(const TickState& state) const;

    /// A finer surface that the page draws in place of the model's boundary.
    void carry(const CarriedSurface& surface);

    /// The bytes of it that a page fetches (cli/view/PROTOCOL.md, `surface`); empty where there is none.
    const std::string& carried() const { return carried_; }

    /// How far the model is off where FE know it; of a model in space.
    void know(std::vector<KnownError> errors);

    /// Of a model that learns while it plays.
    void learn(LearnedField field) { learned_ = std::move(field); }

    /// The message of type `learned` (cli/view/PROTOCOL.md); of what learn() was told.
    std::string message(const Lesson::News& news) const;

    /// The message of type `model` (cli/view/PROTOCOL.md). names: of all models served; index: of this one.
    std::string message(const std::vector<std::string>& names, int index) const;

   private:
    const HapticModel& model_;
    SpringMesh mesh_;
    FreeSurface surface_;
    Eigen::VectorXd tau_s_, contact_share_;   ///< how the law relaxes under the tool (K); often none
    std::optional<LearnedField> learned_;
    std::vector<int> shown_;
    NoduleSurface nodule_;
    CarriedPoints nodule_carried_;
    std::vector<KnownError> errors_;
    std::string carried_;
    std::vector<Place> places_;
    std::vector<Box> boxes_;
    int first_ = 0;
};

}  // namespace tissue::serve
