// Search for the cube of an embedded lattice at a position, or the nearest one.
#include "mesh/cube_search.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "embedded_block.h"

using namespace tissue;

TEST_CASE("CubeSearch finds the containing or the nearest cube as an exhaustive search does", "[embedded]") {
    SpringMesh mesh = embedded_block(Lattice{{4, 3, 3}, {0.04, 0.03, 0.03}});
    const double h = mesh.embedding.spacing_m;
    const Cells& all = mesh.embedding.cubes;
    std::mt19937_64 random(5);
    const auto draw = [&](double low, double high) { return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53; };
    for (const bool holes : {false, true}) {
        Cells cubes(0, 8);
        for (Eigen::Index c = 0; c < all.rows(); ++c)
            if (!holes || draw(0, 1) < 0.5) {
                cubes.conservativeResize(cubes.rows() + 1, 8);
                cubes.row(cubes.rows() - 1) = all.row(c);
            }
        const CubeSearch search(mesh.nodes, cubes, h);
        const auto low = [&](Eigen::Index c) { return Eigen::Vector3d(mesh.nodes.row(cubes(c, 0)).transpose()); };
        Eigen::Vector3d origin = low(0);
        for (Eigen::Index c = 0; c < cubes.rows(); ++c) origin = origin.cwiseMin(low(c));
        int beyond = 0;
        for (int k = 0; k < 3000; ++k) {
            // some positions on planes of faces, where two cubes are equally near
            Eigen::Vector3d place(draw(-0.015, 0.055), draw(-0.015, 0.045), draw(-0.015, 0.045));
            if (k % 3 == 0) place[k % 9 / 3] = h * std::round(place[k % 9 / 3] / h);
            if (k % 5 == 0) place = h * (place / h).array().round();
            const CubeSearch::Found found = search.at(place);
            // reference: the containing cube, or the first of the nearest in the order of z, y, x
            const Eigen::Vector3d local = (place - origin) / h, here = local.array().floor();
            double least = std::numeric_limits<double>::infinity();
            int nearest = -1;
            Eigen::Vector3d at;
            for (int around = -1; around < 27 && least > 0; ++around) {
                const Eigen::Vector3d looked = around < 0 ? here : Eigen::Vector3d(here + Eigen::Vector3d(around % 3 - 1, around / 3 % 3 - 1, around / 9 - 1));
                for (Eigen::Index c = 0; c < cubes.rows(); ++c) {
                    if (Eigen::Vector3d(((low(c) - origin) / h).array().round()) != looked) continue;
                    const double away = around < 0 ? 0 : (local - local.cwiseMax(looked).cwiseMin((looked.array() + 1).matrix())).norm();
                    if (away < least) least = away, nearest = static_cast<int>(c), at = local - looked;
                }
            }
            INFO(place.transpose());
            REQUIRE(found.cube == nearest);
            if (found.cube < 0) continue;
            CHECK(found.away == least);
            CHECK(found.weight == cube_weights(at));
            beyond += found.away > 0;
            Eigen::Vector3d there = Eigen::Vector3d::Zero();
            for (int c = 0; c < 8; ++c) there += found.weight[c] * mesh.nodes.row(cubes(found.cube, c)).transpose();
            CHECK((there - place).norm() < 1e-12);
        }
        CHECK(beyond > 500);
    }
}
