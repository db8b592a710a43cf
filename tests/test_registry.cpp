#include "registry.h"

#include <catch2/catch.hpp>

#include "mesh/solid_block.h"
#include "mesh/topology.h"
#include "refusal.h"
#include "springs/spring_law.h"

using namespace tissue;
using Catch::Matchers::Equals;

TEST_CASE("a registry finds entries by name in their order and lists them for an unknown name") {
    const Registry<std::pair<std::string, int>> colours("colour", {{"red", 1}, {"blue", 2}},
                                                        [](const auto& colour) { return colour.first; });
    CHECK(colours.at("blue").second == 2);
    CHECK(colours.names() == std::vector<std::string>{"red", "blue"});
    CHECK_THAT(refusal<MismatchError>([&] { colours.at("green"); }),
               Equals("colour 'green' is not known; allowed: red, blue"));
}

TEST_CASE("every spring law and topology has the name under which it is registered") {
    for (const std::string& name : spring_laws().names()) CHECK(make_spring_law(name)->name() == name);
    for (const std::string& name : topologies().names()) {
        const Topology& kind = topologies().at(name);
        const Lattice lattice = kind.dimension == 3 ? Lattice{{3, 2, 1}, {0.3, 0.2, 0.1}} : Lattice{{3, 2}, {0.3, 0.2}};
        if (kind.on_lattice) CHECK(make_lattice(name, lattice).topology == name);
        if (!kind.needs_lattice()) CHECK(kind.on_shape(kind.dimension == 3 ? solid_block(lattice) : shape_of(make_lattice("grid4", lattice)), lattice.size_m[0] / lattice.cells[0]).topology == name);
    }
}
