#pragma once

#include <map>
#include <string>
#include <vector>

#include "mesh/free_surface.h"
#include "springs/element.h"

namespace tissue {

/// Positions of a mesh's elements at rest: values of the factors of an energy model's terms (springs/energy_model_terms.h). One
/// object per thread; it caches results for one set of springs and one of cells.
class RestPlaces {
   public:
    explicit RestPlaces(const SpringMesh& mesh);

    /// Values of one factor at every row of `nodes`: springs (two columns) or cells. Throws MismatchError for a factor
    /// that is unknown or does not fit; the message lists those that do.
    Eigen::VectorXd factor(const std::string& name, const Cells& nodes) const;

   private:
    struct Nearest {
        double distance_m;
        /// projector on the nearest facet (D x D); the mean of several at equal distance
        Eigen::MatrixXd along;
    };
    Nearest nearest(const Cells& facets, const Point& point) const;
    const std::vector<Nearest>& nearest_free(const Cells& nodes) const;  ///< from the middle of each row
    Point middle(const Cells& nodes, Eigen::Index e) const;
    double squared_cosine(const Cells& nodes, Eigen::Index e, const Eigen::MatrixXd& projector) const;
    int axes_of(const Cells& nodes, Eigen::Index e, int& first) const;  ///< number of axes along which a spring runs

    const SpringMesh& mesh_;
    Cells free_, fixed_;               ///< facets
    double spacing_m_;                ///< mean spacing of the free surface's nodes [m]
    Eigen::VectorXd centre_m_, half_size_m_;
    /// cache by the number of columns: many terms use it
    mutable std::map<Eigen::Index, std::vector<Nearest>> known_;
};

}  // namespace tissue
