#include "springs/push_refusal.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "../mesh/embedded_block.h"
#include "../haptic/haptic_example.h"
#include "../solid_model_example.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

Point at(std::initializer_list<double> x) {
    Point p(static_cast<Eigen::Index>(x.size()));
    std::copy(x.begin(), x.end(), p.data());
    return p;
}

}  // namespace

TEST_CASE("an indentation is refused off the surface, on the fixed part, outwards or with invalid numbers", "[push]") {
    const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
    struct Tissue {
        SpringMesh mesh;
        Point contact, into, along, held_node, held_middle;
    };
    const Tissue tissues[] = {
        {make_lattice("grid8", 10, 10, 0.1, 0.1), at({0.05, 0.1}), at({0, -0.004}), at({0.004, 0}), at({0, 0}), at({0.05, 0})},
        {embedded_block(Lattice{{5, 4, 3}, {0.05, 0.06, 0.02}}), at({0.025, 0.03, 0.02}), at({0, 0, -0.004}), at({0.004, 0, 0}), at({0, 0, 0}), at({0.025, 0.03, 0})},
    };
    for (const Tissue& t : tissues) {
        const FreeSurface surface(t.mesh);
        const auto why = [&](const Point& contact, const Point& push) { return push_refusal(t.mesh, surface, contact, push); };
        INFO("D = " << t.mesh.dimension());
        CHECK(why(t.contact, t.into) == "");
        CHECK(why(t.contact, t.along) == "");
        CHECK(why(t.contact, 0 * t.into) == "");
        CHECK(why(t.contact - 0.4 * t.into, t.into) == "");  // 1.6 mm above the surface
        CHECK_THAT(why(t.contact, -t.into), Contains("out of the tissue"));
        CHECK_THAT(why(t.contact, t.along - 0.001 * t.into), Contains("out of the tissue"));
        CHECK_THAT(why(t.contact - t.into, t.into), Contains("4 mm off the surface, more than 2 mm"));
        CHECK_THAT(why(Point(t.contact.array() + 5), t.into), Contains("off the surface"));
        CHECK_THAT(why(t.held_node, t.into), Contains("on a fixed part"));
        CHECK_THAT(why(t.held_middle, -t.into), Contains("on a fixed part"));
        for (double none : {nan, infinite}) {
            Point contact = t.contact, push = t.into;
            contact[0] = push[0] = none;
            CHECK_THAT(why(contact, t.into), Contains("has a number that is not finite"));
            CHECK_THAT(why(t.contact, push), Contains("has a number that is not finite"));
        }
        CHECK_THAT(why(at({0.1}), t.into), Contains("axes"));
        CHECK_THAT(why(t.contact, at({0.1})), Contains("axes"));
    }
}
