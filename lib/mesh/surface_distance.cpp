#include "mesh/surface_distance.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <cmath>
#include <vector>

#include "error.h"

namespace tissue {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangle = Kernel::Triangle_3;

}  // namespace

struct SurfaceDistance::Tree {
    std::vector<Triangle> triangles;
    CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, std::vector<Triangle>::const_iterator>>> boxes;
};

SurfaceDistance::SurfaceDistance(const MshFile& mesh, double unit_m) {
    const auto tree = std::make_shared<Tree>();
    const auto point = [&](int i) {
        const MshFile::Point& p = mesh.points[static_cast<std::size_t>(i)];
        return Kernel::Point_3(p.x * unit_m, p.y * unit_m, p.z * unit_m);
    };
    for (const MshFile::Element& e : mesh.triangles) {
        const Triangle t(point(e.node[0]), point(e.node[1]), point(e.node[2]));
        if (t.squared_area() > 0) tree->triangles.push_back(t);
    }
    if (tree->triangles.empty()) throw FileError(mesh.file + ": has no triangle with an area");
    tree->boxes.insert(tree->triangles.begin(), tree->triangles.end());
    tree->boxes.build();
    tree->boxes.accelerate_distance_queries();  // else the first query does this, in whichever thread
    tree_ = tree;
}

double SurfaceDistance::operator()(const Eigen::Vector3d& place_m) const {
    return std::sqrt(tree_->boxes.squared_distance(Kernel::Point_3(place_m.x(), place_m.y(), place_m.z())));
}

}  // namespace tissue
