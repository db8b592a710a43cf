#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// A few spring sets and their shares: each in [0, 1], together 1.
struct SetWeights {
    static constexpr int most = 8;  ///< two contacts, two angles each, two magnitudes each
    int count = 0;
    int set[most] = {};
    double weight[most] = {};
};

struct SelectorOptions {
    enum class Mode { nearest, blended } mode = Mode::nearest;       ///< nearest: Sec. 4.3
    enum class By { displacement, force } by = By::displacement;     ///< force: Sec. 4.3 as printed
};

/// Sec. 4.3: which spring sets serve a contact. First the trained contact, then the angle of the push there, then its
/// magnitude; `nearest` takes the nearest of each, `blended` shares linearly between the two neighbours of each, along
/// the outline, in angle and in magnitude. Below the smallest magnitude and beyond the largest, that one serves alone.
/// Angles farther apart than half a turn are not blended but in the middle 90 degrees of their gap, so that a push
/// outside what was trained is served by its nearest angle and the shares stay continuous.
/// A function of contact position and x_p - X_p alone, in evaluation and tick alike; by force: of the force on the
/// tissue there and of the forces that the sets themselves give at their load case. Constants only; select() does not
/// allocate.
class Selector {
   public:
    /// Throws MismatchError when a contact of the model is not on the outline, or (by force) a set has no equilibrium
    /// under its own load case.
    Selector(const TissueModel& model, const Eigen::Ref<const NodeField>& theta, const SelectorOptions& options);

    /// segment, w: of the outline at rest. push: x_p - X_p [m], or the force on the tissue [N].
    SetWeights select(int segment, double w, const Eigen::Vector2d& push) const noexcept;

    const SelectorOptions& options() const { return options_; }

   private:
    struct Magnitude { double size; int set; };
    struct Angle { double radians; std::vector<Magnitude> magnitudes; };
    struct Contact { Eigen::Vector2d position_m; double along_m; std::vector<Angle> angles; };

    void add(const Contact& contact, double share, const Eigen::Vector2d& push, SetWeights& out) const noexcept;
    void add(const Angle& angle, double share, double size, SetWeights& out) const noexcept;

    SelectorOptions options_;
    std::vector<Eigen::Vector2d> outline_m_, normal_;  ///< rest positions of outline nodes; inward normals of segments (M)
    std::vector<double> along_m_;                      ///< arc length at each outline node, and the whole at the end (M + 1)
    std::vector<Contact> contacts_;                    ///< by arc length
    double small_;                                     ///< added along the inward normal, so that a push of nothing has an angle
};

}  // namespace tissue
