#pragma once

#include <string>

#include "mesh/outline.h"
#include "springs/element.h"

namespace tissue {

/// Where the elements of a mesh are at rest: what the terms of an energy law are made of (springs/energy_law.h).
class RestPlaces {
   public:
    explicit RestPlaces(const SpringMesh& mesh);

    /// One factor of a term at every row of `nodes`: springs (two columns) or cells. Throws MismatchError for a factor
    /// that is not known or does not fit, naming those that do.
    Eigen::VectorXd factor(const std::string& name, const Cells& nodes) const;

   private:
    struct Segment {
        int node[2];
        Eigen::Vector2d from, along;  ///< along: to the other end, not of unit length
    };
    struct Nearest {
        double distance_m;
        Eigen::Matrix2d direction;    ///< t t' of the nearest segment, the mean where several are equally near
    };
    static Nearest nearest(const std::vector<Segment>& segments, const Eigen::Vector2d& point);
    Eigen::Vector2d middle(const Cells& nodes, Eigen::Index e) const;
    double squared_cosine(const Cells& nodes, Eigen::Index e, const Eigen::Matrix2d& direction) const;

    const SpringMesh& mesh_;
    std::vector<Segment> free_, held_;
    double spacing_m_;
    Eigen::Vector2d centre_m_, half_size_m_;
};

}  // namespace tissue
