#include "mesh/region_lookup.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "error.h"

namespace tissue {

RegionLookup::RegionLookup(const MshFile& mesh, const std::vector<std::string>& regions, double unit_m) {
    if (mesh.tetrahedra.empty()) throw FileError(mesh.file + ": has no tetrahedra and therefore no regions");
    const std::vector<int> tags = group_tags(regions, mesh.tetrahedron_names, "volume", mesh.file);
    for (const MshFile::Tetrahedron& e : mesh.tetrahedra) {
        Eigen::Matrix<double, 4, 3> corners_m;
        for (int k = 0; k < 4; ++k) {
            const MshFile::Point& p = mesh.points[static_cast<std::size_t>(e.node[k])];
            corners_m.row(k) << p.x * unit_m, p.y * unit_m, p.z * unit_m;
        }
        const auto tag = std::find(tags.begin(), tags.end(), e.physical);
        add(corners_m, tag == tags.end() ? 0 : static_cast<int>(tag - tags.begin()) + 1);
    }
    sort();
}

RegionLookup::RegionLookup(const Shape& shape) {
    for (Eigen::Index t = 0; t < shape.simplices.rows(); ++t) {
        Eigen::Matrix<double, 4, 3> corners_m;
        for (int k = 0; k < 4; ++k) corners_m.row(k) = shape.nodes.row(shape.simplices(t, k));
        add(corners_m, shape.region[static_cast<std::size_t>(t)]);
    }
    sort();
}

void RegionLookup::add(const Eigen::Matrix<double, 4, 3>& corners_m, int region) {
    Tetrahedron t;
    t.origin_m = corners_m.row(0).transpose();
    t.low_m = corners_m.colwise().minCoeff().transpose();
    t.high_m = corners_m.colwise().maxCoeff().transpose();
    const Eigen::Matrix3d sides = (corners_m.bottomRows<3>().rowwise() - corners_m.row(0)).transpose();
    if (!(std::abs(sides.determinant()) > 0)) return;  // flat: contains no position
    const Eigen::Matrix3d weights = sides.inverse();  // rows: gradients of the corners' weights
    t.inward << -weights.colwise().sum(), weights;
    t.far_m = 1 / t.inward.row(0).norm();
    t.inward.rowwise().normalize();
    t.region = region;
    longest_m_ = std::max(longest_m_, t.high_m.x() - t.low_m.x());
    tetrahedra_.push_back(t);
}

void RegionLookup::sort() {
    // a tetrahedron listed twice, in a region and in the base material, counts as the region's
    std::stable_sort(tetrahedra_.begin(), tetrahedra_.end(), [](const Tetrahedron& a, const Tetrahedron& b) {
        return a.low_m.x() != b.low_m.x() ? a.low_m.x() < b.low_m.x() : a.region > b.region;
    });
}

double RegionLookup::out_of_m(const Tetrahedron& t, const Eigen::Vector3d& position_m) {
    constexpr double rounding_m = 1e-12;
    Eigen::Vector4d into = t.inward * (position_m - t.origin_m);
    into[0] += t.far_m;
    return std::max(0.0, -into.minCoeff() - rounding_m);
}

std::optional<int> RegionLookup::inside(const Eigen::Vector3d& position_m) const {
    const auto first = std::lower_bound(tetrahedra_.begin(), tetrahedra_.end(), position_m.x() - longest_m_,
                                        [](const Tetrahedron& t, double x) { return t.low_m.x() < x; });
    for (auto t = first; t != tetrahedra_.end() && t->low_m.x() <= position_m.x(); ++t)
        if ((position_m.array() >= t->low_m.array()).all() && (position_m.array() <= t->high_m.array()).all() && out_of_m(*t, position_m) == 0) return t->region;
    return {};
}

int RegionLookup::at(const Eigen::Vector3d& position_m) const {
    if (const auto region = inside(position_m)) return *region;
    double least_m = std::numeric_limits<double>::infinity();
    int region = 0;
    for (const Tetrahedron& t : tetrahedra_)
        if (const double out = out_of_m(t, position_m); out < least_m) {
            least_m = out;
            region = t.region;
        }
    return region;
}

std::string to_msh(const MshFile& mesh, const RegionLookup& regions) {
    constexpr int tissue_label = 10;
    std::string text = fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", mesh.points.size());
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
        text += fmt::format("{} {} {} {}\n", i + 1, mesh.points[i].x, mesh.points[i].y, mesh.points[i].z);
    text += fmt::format("$EndNodes\n$Elements\n{}\n", mesh.triangles.size() + mesh.tetrahedra.size());
    long number = 0;
    for (const MshFile::Element& e : mesh.triangles)
        text += fmt::format("{} 2 2 {} {} {} {} {}\n", ++number, e.physical, e.physical, e.node[0] + 1, e.node[1] + 1, e.node[2] + 1);
    for (const MshFile::Tetrahedron& e : mesh.tetrahedra) {
        Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
        for (int node : e.node) {
            const MshFile::Point& p = mesh.points[static_cast<std::size_t>(node)];
            middle_m += Eigen::Vector3d(p.x, p.y, p.z) / 4;
        }
        const int label = tissue_label + regions.at(middle_m);
        text += fmt::format("{} 4 2 {} {} {} {} {} {}\n", ++number, label, label, e.node[0] + 1, e.node[1] + 1, e.node[2] + 1, e.node[3] + 1);
    }
    return text + "$EndElements\n";
}

}  // namespace tissue
