#pragma once

#include <map>
#include <string>
#include <vector>

#include "mesh/free_surface.h"
#include "springs/element.h"

namespace tissue {

/// Where the elements of a mesh are at rest: what the terms of an energy law are made of (springs/energy_law.h). One object
/// a thread, asked of the same springs and cells.
class RestPlaces {
   public:
    explicit RestPlaces(const SpringMesh& mesh);

    /// One factor of a term at every row of `nodes`: springs (two columns) or cells. Throws MismatchError for a factor
    /// that is not known or does not fit, naming those that do.
    Eigen::VectorXd factor(const std::string& name, const Cells& nodes) const;

   private:
    struct Nearest {
        double distance_m;
        Eigen::MatrixXd along;        ///< projector on the nearest facet (D x D), the mean where several are equally near
    };
    Nearest nearest(const Cells& facets, const Point& point) const;
    const std::vector<Nearest>& nearest_free(const Cells& nodes) const;  ///< to the middle of each row
    Point middle(const Cells& nodes, Eigen::Index e) const;
    double squared_cosine(const Cells& nodes, Eigen::Index e, const Eigen::MatrixXd& projector) const;
    int axes_of(const Cells& nodes, Eigen::Index e, int& first) const;  ///< how many axes a spring runs along

    const SpringMesh& mesh_;
    Cells free_, held_;               ///< facets
    double spacing_m_;                ///< mean, of the free surface's nodes
    Eigen::VectorXd centre_m_, half_size_m_;
    mutable std::map<Eigen::Index, std::vector<Nearest>> known_;  ///< by the number of columns: many terms ask
};

}  // namespace tissue
