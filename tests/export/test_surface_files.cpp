#include "export/surface_files.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cstring>
#include <nlohmann/json.hpp>

#include "../mesh/embedded_block.h"
#include "mesh/topology.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

struct Example {
    SpringMesh mesh = embedded_block(Lattice{{2, 2, 1}, {0.04, 0.04, 0.02}});
    CarriedSurface surface = own_surface(mesh);
    NodeField u = (50 * mesh.nodes.array()).sin() * 1e-3;
    IndentedSurface press{surface, "top-3mm", surface.moved(u), Eigen::Vector3d(0.02, 0.02, 0.02), Eigen::Vector3d(0, 0, -0.003), Eigen::Vector3d(0.01, 0, -0.2)};
};

}  // namespace

TEST_CASE("a .glb export has the surface at rest with z up and the displacement as morph target", "[export]") {
    const Example e;
    const std::string bytes = surface_glb(e.press);
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
    const auto holds = [&](const nlohmann::json& attributes, const NodeField& wanted) {
        const auto& accessor = model["accessors"][attributes["POSITION"].get<std::size_t>()];
        const auto& view = model["bufferViews"][accessor["bufferView"].get<std::size_t>()];
        const std::size_t at = 20 + text + 8 + view["byteOffset"].get<std::size_t>();
        REQUIRE(view["byteLength"] == 4 * wanted.size());
        for (Eigen::Index v = 0; v < wanted.rows(); ++v)
            for (int d = 0; d < 3; ++d) {
                float value = 0;
                std::memcpy(&value, bytes.data() + at + 4 * static_cast<std::size_t>(3 * v + d), 4);
                CHECK(value == static_cast<float>(wanted(v, d)));
            }
        for (int d = 0; d < 3; ++d) CHECK((accessor["min"][static_cast<std::size_t>(d)] == wanted.col(d).cast<float>().minCoeff() && accessor["max"][static_cast<std::size_t>(d)] == wanted.col(d).cast<float>().maxCoeff()));
    };
    holds(model["meshes"][0]["primitives"][0]["attributes"], e.surface.vertices);
    holds(target, e.press.places - e.surface.vertices);
    const std::vector<double> q = model["nodes"][0]["rotation"];
    const Eigen::Vector3d up = Eigen::Quaterniond(q[3], q[0], q[1], q[2]) * Eigen::Vector3d::UnitZ();
    CHECK((up - Eigen::Vector3d::UnitY()).norm() < 1e-12);
}

TEST_CASE("a .vtp export has every point and facet of the surface and the contact force", "[export]") {
    const Example e;
    const std::string text = surface_vtp(e.press);
    CHECK_THAT(text, Contains("NumberOfPoints=\"" + std::to_string(e.surface.vertices.rows()) + "\"") && Contains("NumberOfPolys=\"" + std::to_string(e.surface.facets.rows()) + "\""));
    CHECK_THAT(text, Contains("Name=\"force_N\" NumberOfComponents=\"3\" NumberOfTuples=\"1\" format=\"ascii\">0.01 0 -0.2 "));
}
