#include "export/surface_files.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <nlohmann/json.hpp>

#include "../example.h"
#include "mesh/topology.h"
#include "surface_file/surface_file.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

struct Example {
    SpringMesh mesh = make_lattice("grid26", Lattice{{2, 2, 1}, {0.04, 0.04, 0.02}});
    CarriedSurface surface = own_surface(mesh);
    NodeField u = (50 * mesh.nodes.array()).sin() * 1e-3;
    PressedSurface press{surface, "top-3mm", surface.moved(u), Eigen::Vector3d(0.02, 0.02, 0.02), Eigen::Vector3d(0, 0, -0.003), Eigen::Vector3d(0.01, 0, -0.2)};
};

}  // namespace

TEST_CASE("a press as .glb: our reader has the surface at rest with z turned up, its target is the displacement", "[export]") {
    const Example e;
    const std::string bytes = surface_glb(e.press);
    TemporaryFolder folder;
    const MshFile read = read_surface_file(folder.file("press.glb", bytes));
    REQUIRE(read.points.size() == static_cast<std::size_t>(e.surface.vertices.rows()));
    REQUIRE(read.triangles.size() == static_cast<std::size_t>(e.surface.facets.rows()));
    for (std::size_t v = 0; v < read.points.size(); ++v) {  // the standard's y is our z, its z our -y
        const auto row = e.surface.vertices.row(static_cast<Eigen::Index>(v));
        CHECK(read.points[v].x == Approx(row[0]).margin(1e-8));
        CHECK(read.points[v].y == Approx(row[2]).margin(1e-8));
        CHECK(read.points[v].z == Approx(-row[1]).margin(1e-8));
    }
    std::uint32_t length = 0, text = 0;
    std::memcpy(&length, bytes.data() + 8, 4);
    std::memcpy(&text, bytes.data() + 12, 4);
    CHECK(length == bytes.size());
    const nlohmann::json model = nlohmann::json::parse(bytes.substr(20, text));
    const auto& extras = model["nodes"][0]["extras"];
    CHECK(extras["case"] == "top-3mm");
    CHECK(extras["force_N"] == std::vector<double>{0.01, 0, -0.2});
    CHECK(model["meshes"][0]["extras"]["targetNames"][0] == "pressed");
    const auto& target = model["meshes"][0]["primitives"][0]["targets"][0];
    const auto& view = model["bufferViews"][model["accessors"][target["POSITION"].get<std::size_t>()]["bufferView"].get<std::size_t>()];
    const std::size_t at = 20 + text + 8 + view["byteOffset"].get<std::size_t>();
    const NodeField moved = e.press.places - e.surface.vertices;
    REQUIRE(view["byteLength"] == 4 * moved.size());
    for (Eigen::Index v = 0; v < moved.rows(); ++v)
        for (int d = 0; d < 3; ++d) {
            float value = 0;
            std::memcpy(&value, bytes.data() + at + 4 * static_cast<std::size_t>(3 * v + d), 4);
            CHECK(value == static_cast<float>(moved(v, d)));
        }
}

TEST_CASE("a press as .vtp: every facet, and what was pushed how far and with which force", "[export]") {
    const Example e;
    const std::string text = surface_vtp(e.press);
    CHECK_THAT(text, Contains("NumberOfPoints=\"" + std::to_string(e.surface.vertices.rows()) + "\"") && Contains("NumberOfPolys=\"" + std::to_string(e.surface.facets.rows()) + "\""));
    CHECK_THAT(text, Contains("Name=\"force_N\" NumberOfComponents=\"3\" NumberOfTuples=\"1\" format=\"ascii\">0.01 0 -0.2 "));
}
