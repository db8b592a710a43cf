#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "eval/statistics.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Force of straight pushes of one depth over the surface of a solid with a nodule, in finite elements and in the law: what a
/// finger finds that looks for the nodule.
struct ForceMap {
    struct Place {
        std::string name;
        Point contact_m;
        double fe_N;                      ///< along the push
        std::optional<double> learned_N;  ///< absent where the law has no answer
    };
    double depth_m = 0;
    std::vector<Place> places;            ///< in the study's order
    std::vector<std::string> lost;        ///< "name: why", pushes that FE has no answer to

    /// Force at the place nearest to the nodule's middle over that at the place farthest from it, the mean of several.
    struct Contrast {
        Point over_m;
        std::vector<Point> far_m;
        double fe;
        std::optional<double> learned;    ///< absent where the law has no answer at one of them
    };
    /// |learned - fe| / |fe| of all places that were pushed.
    Statistics error() const;

    std::optional<Contrast> contrast;     ///< absent where the model has no nodule, or fewer than two places an answer

    bool empty() const { return places.empty() && lost.empty(); }
};

/// The cases' paths of role map; none: an empty map. The model must have a law where there are some.
ForceMap force_map(const TissueModel& model, const Cases& cases, int threads);

}  // namespace tissue
