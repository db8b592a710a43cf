#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "eval/statistics.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Forces of indentations of one depth at many places of a solid's surface, in FE and in the energy model. Shows
/// whether a stiff inclusion (nodule) can be found by palpation.
struct ForceMap {
    struct Place {
        std::string name;
        Point contact_m;
        double fe_N;                      ///< FE force along the tool displacement
        std::optional<double> learned_N;  ///< of the energy model; absent without an equilibrium
    };
    double depth_m = 0;
    std::vector<Place> places;            ///< in the study's order
    std::vector<std::string> lost;        ///< "name: why", indentations without an FE reference

    /// Ratio of the force at the place nearest to the centre of the inclusion to the force at the place farthest from
    /// it (mean over equally far places).
    struct Contrast {
        Point over_m;
        std::vector<Point> far_m;
        double fe;
        std::optional<double> learned;    ///< absent where the energy model has no equilibrium at one of these places
    };
    /// Quantiles of |learned - fe| / |fe| over all places; `lost` ones count as missing references.
    Statistics error() const;

    std::optional<Contrast> contrast;     ///< absent without an inclusion, or with fewer than two FE references

    bool empty() const { return places.empty() && lost.empty(); }
};

/// Evaluates the paths of role "map" of the cases; without any the map is empty. threads: without influence on the
/// result. Throws MismatchError where there are such paths and the model has no energy model.
ForceMap force_map(const TissueModel& model, const Cases& cases, int threads);

}  // namespace tissue
