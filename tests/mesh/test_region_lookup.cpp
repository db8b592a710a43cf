#include <catch2/catch.hpp>

#include "error.h"
#include "mesh/region_lookup.h"
#include "../example.h"
#include "../refusal.h"
#include "dome.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

Eigen::Vector3d middle(const MshFile& mesh, const MshFile::Tetrahedron& e) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int node : e.node) {
        const MshFile::Point& p = mesh.points[static_cast<std::size_t>(node)];
        sum += Eigen::Vector3d(p.x, p.y, p.z) / 4;
    }
    return sum;
}

/// The dome in millimetres; its tetrahedra above x = 5 mm are "stone" 8, those below x = -10 mm "bone" 9.
MshFile stony_dome() {
    MshFile mesh = dome_file(6);
    for (MshFile::Tetrahedron& e : mesh.tetrahedra) {
        const double x = middle(mesh, e).x();
        if (x > 5) e.physical = 8;
        if (x < -10) e.physical = 9;
    }
    mesh.tetrahedron_names = {{7, "flesh"}, {8, "stone"}, {9, "bone"}};
    return mesh;
}

}  // namespace

TEST_CASE("a position has the region of the tetrahedron that contains it or of the nearest one") {
    const MshFile mesh = stony_dome();
    const RegionLookup regions(mesh, {"bone", "stone"}, 0.001);
    for (const MshFile::Tetrahedron& e : mesh.tetrahedra)
        CHECK(regions.at(1e-3 * middle(mesh, e)) == (e.physical == 7 ? 0 : e.physical == 9 ? 1 : 2));
    CHECK(regions.at({0.0503, 0, 0}) == 2);
    CHECK(regions.at({-0.0503, 0, 0}) == 1);
    CHECK(regions.at({0, 0, 0.0503}) == 0);
    MshFile twice = mesh;  // tetrahedra in two groups: the study's region counts
    for (MshFile::Tetrahedron e : mesh.tetrahedra)
        if (e.physical == 8) {
            e.physical = 7;
            twice.tetrahedra.insert(twice.tetrahedra.begin(), e);
        }
    CHECK(RegionLookup(twice, {"stone"}, 0.001).at({0.03, 0, 0.01}) == 1);
}

TEST_CASE("tetrahedra of an FE mesh are labelled by the region of their centroid") {
    const RegionLookup regions(stony_dome(), {"bone", "stone"}, 0.001);
    MshFile fine = dome_file(14);
    for (MshFile::Point& p : fine.points) p = {1e-3 * p.x, 1e-3 * p.y, 1e-3 * p.z};
    const TemporaryFolder folder;
    const MshFile labelled = read_msh(folder.file("a.msh", to_msh(fine, regions)), true);
    REQUIRE(labelled.tetrahedra.size() == fine.tetrahedra.size());
    REQUIRE(labelled.triangles.size() == fine.triangles.size());
    for (std::size_t i = 0; i < labelled.triangles.size(); ++i) CHECK(labelled.triangles[i].physical == fine.triangles[i].physical);
    int count[3] = {};
    for (const MshFile::Tetrahedron& e : labelled.tetrahedra) {
        const int region = regions.at(middle(labelled, e));
        CHECK(e.physical == 10 + region);
        ++count[region];
    }
    CHECK(count[0] > 0);
    CHECK(count[1] > 0);
    CHECK(count[2] > count[1]);
}

TEST_CASE("an unknown region is refused with the known ones; a mesh without tetrahedra is refused") {
    CHECK_THAT(refusal<FileError>([] { RegionLookup(stony_dome(), {"stnoe"}, 1); }), Contains("dome.msh: has no physical volume 'stnoe'; it has: flesh, stone, bone"));
    MshFile skin = stony_dome();
    skin.tetrahedra.clear();
    CHECK_THAT(refusal<FileError>([&] { RegionLookup(skin, {"stone"}, 1); }), Contains("has no tetrahedra"));
}
