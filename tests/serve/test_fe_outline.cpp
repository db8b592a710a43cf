#include <catch2/catch.hpp>

#include "../wait_for.h"
#include "serve_example.h"

using namespace tissue;
using namespace tissue::serve;
using Json = nlohmann::json;

TEST_CASE("near messages have the FE surface of cases.h5 at every load case and are sent once per change of place", "[serve][long]") {
    const TissueModel tissue = with_forces();
    const Cases cases = cases_of(tissue);
    Stand s(cases);
    CHECK(s.stage->warnings().empty());
    s.show->join(1);
    s.stage->start(nullptr);
    const auto nears = [&] {
        std::vector<Json> all;
        for (const Json& j : s.heard[1])
            if (j["type"] == "near") all.push_back(j);
        return all;
    };
    REQUIRE(wait_for([&] {   // the demo visits the places
        s.now_s += 0.004;
        s.show->step(s.now_s);
        return nears().size() > 4 && nears().back()["place"] >= 0;
    }));
    const auto& outline = s.stage->model().meshes[0]->springs.outline();
    int before = -2, told = 0;
    for (const Json& near : nears()) {
        const int place = near["place"];
        CHECK(place != before);   // sent on a change, not with every frame
        before = place;
        const Json& rows = near["outline"];
        REQUIRE(rows.size() == (place < 0 ? 0 : 3));
        for (std::size_t k = 0; k < rows.size(); ++k) {
            CHECK(rows[k][0] == (k == 0 ? 0.0 : k == 1 ? 0.010 : 0.015));
            REQUIRE(rows[k][1].size() == outline.size());
            for (std::size_t b = 0; b < outline.size(); ++b)
                for (int d = 0; d < 2; ++d) {
                    const auto& records = cases.paths[static_cast<std::size_t>(place)].records;
                    const double u = k == 0 ? 0 : records[k - 1].displacement(outline[b], d);
                    CHECK(rows[k][1][b][static_cast<std::size_t>(d)].get<double>() == Approx(u).margin(0.51e-7).epsilon(0));
                }
        }
        told += place >= 0;
    }
    CHECK(told > 0);
    s.show->join(2);   // a client that joins later gets it too
    Json last;
    for (const Json& j : s.heard[2])
        if (j["type"] == "near") last = j;
    CHECK(last == nears().back());
}

TEST_CASE("a missing cases.h5 gives no FE surface and no warning; a foreign or damaged one gives a one-line warning",
          "[serve]") {
    const TissueModel tissue = with_forces();
    const auto no_outline = [](const Stand& s) {
        for (const Place& place : s.stage->scene().places())
            if (!place.outlines.empty()) return false;
        return true;
    };
    const Stand without;
    CHECK((no_outline(without) && without.stage->warnings().empty()));

    const auto refused = [&](const Cases& cases, const std::string& why) {
        const Stand s(cases);
        const std::vector<std::string>& said = s.stage->warnings();
        INFO(why);
        REQUIRE_FALSE(said.empty());
        CHECK(no_outline(s));
        CHECK(said[0] == s.folder.file("cases.h5") + " is not used: it does not belong to " + s.folder.file("a.h5") + ": " + why);
    };
    Cases study = cases_of(tissue), nodes = study, missing = study, force = study, contact = study, depth = study;
    study.study = "other";
    refused(study, "it is of the study 'other'");
    nodes.nodes(7, 0) += 1e-6;
    refused(nodes, "it has other nodes");
    missing.paths[1].name = "above";
    refused(missing, "it has no load case 'top-10mm'");
    force.paths[2].records[1].contact_force_N *= 1.001;
    refused(force, "its load case 'right-15mm' is another");
    contact.paths[0].contact_m.y() += 1e-6;
    refused(contact, "its load case 'left-10mm' is another");

    depth.magnitudes_m[0] *= 1 + 1e-7;   // the name has six digits and stays the same
    for (LoadPath& path : depth.paths) path.records[0].magnitude_m = depth.magnitudes_m[0];
    refused(depth, "its load case 'left-10mm' is another");

    const TemporaryFolder folder;
    folder.file("cases.h5", "no HDF5");
    const FeCases damaged = read_fe_cases(folder.file("model.h5"), tissue);
    CHECK(damaged.displacement_m.empty());
    CHECK(damaged.warning.find("cases.h5 is not used: ") != std::string::npos);
    CHECK(damaged.warning.find('\n') == std::string::npos);

    Cases measured = cases_of(tissue);   // measured cases: valid, but without displacements inside
    measured.measurement = Measurement{};
    measured.measurement->noise_source = "unknown";
    write_cases(folder.file("cases.h5"), measured, {"test", 1, {}});
    const FeCases hand = read_fe_cases(folder.file("model.h5"), tissue);
    CHECK((hand.displacement_m.empty() && hand.warning.empty()));
}
