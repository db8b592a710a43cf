#include "mesh/inclusion.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../refusal.h"
#include "ball.h"
#include "error.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const Eigen::Vector3d centre(0.03, -0.02, 0.05);
constexpr double radius_m = 0.008, ball_m3 = 4.0 / 3 * 3.14159265358979 * radius_m * radius_m * radius_m;

Surface surface(int divisions) {
    return inclusion_surface(ball_surface(1e3 * centre, 1e3 * radius_m, divisions), 1e-3);
}

}  // namespace

TEST_CASE("an inclusion of a sphere's triangles has the ball's volume and centre and contains the same points", "[inclusion]") {
    const Inclusion ball(centre, radius_m), round(surface(5));
    CHECK((round.centre_m() - centre).norm() < 1e-9);
    CHECK(round.volume_m3() == Approx(ball_m3).epsilon(2e-3));
    CHECK(round.radius_m() == Approx(radius_m).epsilon(1e-3));
    CHECK((round.low_m() - ball.low_m()).norm() < 1e-9);
    for (int k = 0; k < 500; ++k) {
        const Eigen::Vector3d way = Eigen::Vector3d(std::sin(1.0 * k), std::cos(2.3 * k), std::sin(0.7 * k + 1)).normalized();
        for (const double r : {0.0, 0.5, 0.99, 1.001, 1.3}) {
            CAPTURE(k, r);
            CHECK(round.contains(centre + r * radius_m * way) == (r < 1));
            CHECK(ball.contains(centre + r * radius_m * way) == (r < 1));
        }
    }
}

TEST_CASE("inclusion_facets keeps volume and centroid of a surface and has sides of the wanted length", "[inclusion]") {
    MshFile steps = ball_surface(1e3 * centre, 1e3 * radius_m, 5);  // as from voxels of 0.5 mm
    for (MshFile::Point& p : steps.points)
        for (double* x : {&p.x, &p.y, &p.z}) *x = std::round(2 * *x) / 2 + 0.2 * (*x - std::round(2 * *x) / 2);
    for (const Surface& given : {surface(5), inclusion_surface(steps, 1e-3)})
        for (const double most_m : {0.003, 1.0}) {
            const double size_m = std::min(most_m, 0.6 * radius_m);
            const Surface coarse = inclusion_facets(given, most_m);
            const Inclusion made(coarse);
            CHECK(made.volume_m3() == Approx(Inclusion(given).volume_m3()).epsilon(1e-9));
            CHECK((made.centre_m() - Inclusion(given).centre_m()).norm() < 1e-9);
            double sum_m = 0;
            for (Eigen::Index t = 0; t < coarse.triangles.rows(); ++t) {
                for (int k = 0; k < 3; ++k) sum_m += (coarse.corner(t, k) - coarse.corner(t, (k + 1) % 3)).norm();
                CHECK(triangle_quality(coarse.corner(t, 0), coarse.corner(t, 1), coarse.corner(t, 2)) > 0.1);
            }
            const double mean_m = sum_m / static_cast<double>(3 * coarse.triangles.rows());
            CHECK(mean_m > 0.7 * size_m);
            CHECK(mean_m < 1.3 * size_m);
        }
}

TEST_CASE("an inclusion's surface with a hole is refused with its file and first fault", "[inclusion]") {
    MshFile open = ball_surface(centre, radius_m, 2);
    open.triangles.pop_back();
    CHECK_THAT(refusal<FileError>([&] { inclusion_surface(open, 1); }), Contains("ball.stl: 1 hole, perimeter") && Contains(" mm") && Contains("tissuectl surface"));
}

TEST_CASE("to_msh writes an inclusion beside the outer surface and in no physical group", "[inclusion]") {
    const Surface outer = inclusion_surface(ball_surface(centre, 0.05, 2), 1), inner = surface(1);
    const std::string text = to_msh(outer, &inner);
    CHECK_THAT(text, Contains("$Nodes\n" + std::to_string(outer.nodes.rows() + inner.nodes.rows()) + "\n"));
    CHECK_THAT(text, Contains("\n1 2 2 2 2 ") && Contains("\n" + std::to_string(outer.triangles.rows() + 1) + " 2 2 0 4 "));
}
