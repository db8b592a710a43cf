#include "springs/spring_sets.h"

#include <catch2/catch.hpp>

#include "../haptic/haptic_example.h"
#include "../refusal.h"
#include "error.h"

using namespace tissue;
using Catch::Matchers::Contains;

TEST_CASE("spring_sets finds a set by its name; without a name it returns those of all load cases in order") {
    TissueModel model = haptic_example();
    model.one_set *= 2;
    model.optimum *= 3;
    const auto alone = [&](const std::string& set) {
        const std::vector<NamedSet> sets = spring_sets(model, "", set);
        REQUIRE(sets.size() == 1);
        CHECK(sets[0].name == set);
        return sets[0];
    };
    for (const auto& [name, theta] : {std::pair("one_set", &model.one_set), std::pair("heuristic_a", &model.heuristic_a), std::pair("heuristic_b", &model.heuristic_b)}) {
        INFO(name);
        CHECK(alone(name).load_case == -1);
        CHECK(alone(name).theta == *theta);
    }
    for (const std::string& optimizer : {std::string(), model.trained[0].optimizer, std::string("optimum")}) {
        const std::vector<NamedSet> sets = spring_sets(model, optimizer, "");
        REQUIRE(static_cast<int>(sets.size()) == model.case_count());
        for (int c = 0; c < model.case_count(); ++c) {
            const NamedSet& set = sets[static_cast<std::size_t>(c)];
            CHECK(set.name == model.case_names[static_cast<std::size_t>(c)]);
            CHECK(set.load_case == c);
            CHECK(set.theta == sets_of(model, optimizer).row(c).transpose());
        }
    }
    CHECK(alone(model.case_names[3]).load_case == 3);
    CHECK(sets_of(model, "") == model.trained[0].theta);
    CHECK(sets_of(model, "optimum") == model.optimum);
}

TEST_CASE("an unknown spring set or optimiser is refused with a list of the known ones") {
    const TissueModel model = haptic_example();
    CHECK_THAT(refusal<MismatchError>([&] { spring_sets(model, "", "best"); }),
               Contains("spring set 'best' is not in the model; it has one_set, heuristic_a, heuristic_b and one per load case, such as " + model.case_names[0]));
    CHECK_THAT(refusal<MismatchError>([&] { sets_of(model, "luck"); }), Contains("spring sets 'luck' are not in the model; it has ") && Contains("optimum"));
}
