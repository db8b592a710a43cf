#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "../../cli/serve/stage.h"
#include "../example.h"
#include "../haptic/haptic_example.h"
#include "io/atomic_file.h"

using namespace tissue;
using namespace tissue::serve;
using Catch::Matchers::Contains;
using Json = nlohmann::json;

namespace {

/// A model in space and its evaluation: errors of its load cases, one of them missing, and of one drawn contact.
struct Evaluated {
    TemporaryFolder folder;
    TissueModel tissue = solid_example();
    std::string model = folder.file("model.h5");
    Json eval;
    Evaluated() {
        write_model(model, tissue, {"test", 1, {}});
        eval["model_hash"] = file_hash(model);
        for (const std::string& name : tissue.case_names) eval["trained_errors"].push_back({{"name", name}, {"error", 0.02}});
        eval["trained_errors"][1]["error"] = nullptr;
        eval["drawn"]["held_out"] = {{{"name", "held-out-0001"}, {"contact_m", {0.03, 0.04, 0.05}}, {"direction", {0.6, 0, -0.8}}, {"depth_m", 0.004},
                                      {"error", {{"learned", 0.07}, {"untrained", 0.5}}}}};
    }
    KnownErrors read(const Json& j) {
        folder.file("eval.json", j.dump());
        return read_reference_errors(model, tissue);
    }
    /// The warning about an eval.json that is not used.
    std::string refused(const Json& j) { return refused_text(j.dump()); }
    std::string refused_text(const std::string& content) {
        folder.file("eval.json", content);
        return refused_file();
    }
    std::string refused_file() {
        const KnownErrors known = read_reference_errors(model, tissue);
        CHECK(known.all.empty());
        CHECK_THAT(known.warning, Catch::Matchers::StartsWith(folder.file("eval.json") + " is not used: "));
        CHECK(known.warning.find('\n') == std::string::npos);
        return known.warning;
    }
};

}  // namespace

TEST_CASE("known errors are those of load cases and drawn contacts; a missing answer has no value", "[serve]") {
    Evaluated e;
    const KnownErrors known = e.read(e.eval);
    CHECK(known.warning.empty());
    const auto C = static_cast<std::size_t>(e.tissue.case_count());
    REQUIRE(known.all.size() == C + 1);
    for (std::size_t c = 0; c < C; ++c) {
        const auto i = static_cast<Eigen::Index>(c);
        CHECK(known.all[c].role == "trained");
        CHECK(known.all[c].contact_m == e.tissue.contact_m.row(i).transpose());
        CHECK(known.all[c].direction == e.tissue.direction.row(i).transpose());
        CHECK(known.all[c].depth_m == e.tissue.magnitude_m[i]);
        CHECK(known.all[c].force.has_value() == (c != 1));
    }
    CHECK((known.all[C].role == "held_out" && *known.all[C].force == 0.07 && known.all[C].depth_m == 0.004));

    Stage stage({e.model}, StageOptions{{}, false});   // as sent to the page
    CHECK(stage.warnings().empty());
    const Json told = Json::parse(stage.scene().message({"solid"}, 0))["errors"];
    REQUIRE(told.size() == C + 1);
    CHECK((told[0]["error"] == 0.02 && told[1]["error"].is_null() && told[C]["inward"] == Json::parse("[-0.0, -0.0, -1.0]")));
    CHECK((told[C]["role"] == "held_out" && told[C]["contact_m"] == Json::parse("[0.03, 0.04, 0.05]")));
}

TEST_CASE("a model without eval.json and a model in the plane have no known errors", "[serve]") {
    const Evaluated e;
    const KnownErrors none = read_reference_errors(e.model, e.tissue);
    CHECK((none.all.empty() && none.warning.empty()));
    Evaluated plane;
    plane.tissue = haptic_example({"grid8", "axial"});
    CHECK((plane.read(plane.eval).all.empty() && plane.read(plane.eval).warning.empty()));
}

TEST_CASE("an eval.json with another model hash or without one is not used", "[serve]") {
    Evaluated e;
    Json j = e.eval;
    j["model_hash"] = std::string(32, '0');
    CHECK_THAT(e.refused(j), Contains("it is of another model than " + e.model));
    j.erase("model_hash");
    CHECK_THAT(e.refused(j), Contains("it does not say which model it is of"));
    write_model(e.model, e.tissue, {"test again", 1, {}});   // the model was trained again
    CHECK_THAT(e.refused(e.eval), Contains("it is of another model"));
}

TEST_CASE("a faulty eval.json is not used and a one-line warning names the fault", "[serve]") {
    Evaluated e;
    const auto with = [&](const char* at, const Json& value) {
        Json j = e.eval;
        j[Json::json_pointer(at)] = value;
        return e.refused(j);
    };
    const std::string row = "/drawn/held_out/0";
    CHECK_THAT(with("/model_hash", 7), Contains("'model_hash' is of another type"));
    CHECK_THAT(with("/trained_errors", 7), Contains("'trained_errors' is of another type"));
    CHECK_THAT(with("/trained_errors/0/name", "none such\n"), Contains("row 0 of 'trained_errors': the model has no other load case 'none such\\x0a'"));
    CHECK_THAT(with("/trained_errors/1/name", e.tissue.case_names[0]), Contains("no other load case"));
    CHECK_THAT(with("/trained_errors/0", Json::object()), Contains("has no 'name'"));
    for (const Json& wrong : {Json("0.02"), Json(-0.1), Json(1e13), Json(true), Json::array()}) {
        CHECK_THAT(with("/trained_errors/0/error", wrong), Contains("row 0 of 'trained_errors'") && Contains("'error'"));
        CHECK_THAT(with((row + "/error/learned").c_str(), wrong), Contains("row 0 of 'drawn.held_out'") && Contains("'learned'"));
        CHECK_THAT(with((row + "/depth_m").c_str(), wrong), Contains("'depth_m'"));
    }
    CHECK_THAT(with((row + "/error").c_str(), Json::object()), Contains("has no 'learned'"));
    CHECK_THAT(with((row + "/error").c_str(), nullptr), Contains("'error' is of another type"));
    CHECK_THAT(with((row + "/depth_m").c_str(), 0), Contains("'depth_m'"));
    CHECK_THAT(with((row + "/contact_m").c_str(), {0.03, 0.04}), Contains("'contact_m' has 2 entries"));
    CHECK_THAT(with((row + "/contact_m").c_str(), {0.03, 0.04, 0.02}), Contains("'contact_m' "));
    CHECK_THAT(with((row + "/contact_m").c_str(), {0.03, "x", 0.02}), Contains("'contact_m' is no number"));
    CHECK_THAT(with((row + "/direction").c_str(), {0, 0, 1.1}), Contains("'direction' is no unit vector"));
    CHECK_THAT(with(row.c_str(), 3), Contains("has no 'contact_m'"));
    CHECK_THAT(with("/drawn", 3), Contains("'drawn' is of another type"));
    CHECK_THAT(with("/drawn/held_out", 3), Contains("'drawn.held_out' is no list"));
    CHECK_THAT(with("/drawn/<b>", Json::array()), Contains("'drawn' has a role '<b>'"));
    CHECK_THAT(with("/drawn/trained", Json::array()), Contains("'drawn' has a role 'trained'"));
    CHECK(with("/trained_errors/0/name", std::string(100000, 'x')).size() < 1000);

    Json many = e.eval;
    for (int k = 0; k < 2001; ++k) many["drawn"]["held_out"].push_back(many["drawn"]["held_out"][0]);
    CHECK_THAT(e.refused(many), Contains("more than 2000 contacts"));
    for (const std::string& text : {std::string(), std::string("[]"), std::string("null"), std::string("{"), std::string("\0\xff", 2),
                                    std::string("{\"model_hash\": 1e999}"), std::string(100000, '[')})
        e.refused_text(text);
    const std::string file = e.folder.file("eval.json");
    std::filesystem::resize_file(file, (1 << 24) + 1);
    CHECK_THAT(e.refused_file(), Contains("it has more than 16 MB"));
    std::filesystem::remove(file);
    std::filesystem::create_directory(file);
    CHECK_THAT(e.refused_file(), Contains("it is no file"));
    std::filesystem::remove(file);
    const std::string whole = e.eval.dump();
    for (std::size_t k = 0; k < whole.size(); k += 7) e.refused_text(whole.substr(0, k));
}
