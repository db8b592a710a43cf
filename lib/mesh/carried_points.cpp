#include "mesh/carried_points.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <limits>
#include <vector>

#include "error.h"

namespace tissue {
namespace {

struct Tetrahedron {
    Eigen::Vector3d first, low, high;  ///< corner 0; lower and upper corner of the bounding box
    Eigen::Matrix3d inverse;           ///< inverse of the matrix of the three edges from corner 0

    bool boxes(const Eigen::Vector3d& p, double more_m) const {
        return (p.array() >= low.array() - more_m).all() && (p.array() <= high.array() + more_m).all();
    }
    Eigen::Vector4d weights(const Eigen::Vector3d& p) const {
        Eigen::Vector4d w;
        w.tail<3>() = inverse * (p - first);
        w[0] = 1 - w.tail<3>().sum();
        return w;
    }
};

}  // namespace

CarriedPoints carried_points(const SpringMesh& mesh, const NodeField& points) {
    if (!mesh.is_solid()) throw MismatchError("points inside the tissue need a mesh in space, and this one is in the plane");
    std::vector<Tetrahedron> all;
    for (const auto& t : mesh.simplices.rowwise()) {
        Eigen::Matrix<double, 3, 4> corner;
        for (int k = 0; k < 4; ++k) corner.col(k) = mesh.nodes.row(t[k]).transpose();
        const Eigen::Matrix3d sides = corner.rightCols<3>().colwise() - corner.col(0);
        all.push_back({corner.col(0), corner.rowwise().minCoeff(), corner.rowwise().maxCoeff(), sides.inverse()});
    }
    const double rounding_m = 1e-9 * mesh.size_m();
    CarriedPoints carried{Cells(points.rows(), 4), NodeField(points.rows(), 4)};
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const Eigen::Vector3d p = points.row(v).transpose();
        double best = -std::numeric_limits<double>::infinity();
        // first the tetrahedra whose box contains the point; all of them if the point lies in none
        for (const bool any : {false, true}) {
            if (any && best > -1e-6) break;
            for (std::size_t t = 0; t < all.size(); ++t) {
                if (!any && !all[t].boxes(p, rounding_m)) continue;
                const Eigen::Vector4d w = all[t].weights(p);
                if (!(w.minCoeff() > best)) continue;
                best = w.minCoeff();
                carried.node.row(v) = mesh.simplices.row(static_cast<Eigen::Index>(t));
                carried.weight.row(v) = w.transpose();
            }
        }
    }
    return carried;
}

}  // namespace tissue
