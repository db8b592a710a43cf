#include <catch2/catch.hpp>

#include "../example.h"
#include "../mesh/dome.h"
#include "../mutations.h"
#include "../refusal.h"
#include "../solid_model_example.h"
#include "error.h"
#include "mesh/embedded_lattice.h"
#include "mesh/free_surface.h"
#include "springs/tissue_table.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

TissueModel with_nodule() {
    TissueModel model = solid_model_example(embedded_lattice(dome(6), 0.011));
    model.heuristic_b = model.heuristic_a;
    model.contact_m = FreeSurface(model.mesh).nearest(Eigen::Vector3d(0, 0, 0.05)).point_m.transpose();
    model.direction = Eigen::RowVector3d(0, 0, -1);
    model.nodule = nodule_surface(Inclusion(Eigen::Vector3d(0.005, 0, 0.03), 0.008));
    return model;
}

const Provenance by_test = {"tissuectl test", 11, {}};

}  // namespace

TEST_CASE("a model's nodule is read back unchanged and leaves the format version unchanged", "[nodule]") {
    const TemporaryFolder folder;
    TissueModel model = with_nodule();
    write_model(folder.file("model.h5"), model, by_test);
    const NoduleSurface back = read_model(folder.file("model.h5")).nodule;
    CHECK(back.points == model.nodule.points);
    CHECK(back.triangles == model.nodule.triangles);
    const double version = Hdf5Reader(folder.file("model.h5"), "model").number_attribute("/", "format_version");
    model.nodule = {};
    write_model(folder.file("without.h5"), model, by_test);
    const Hdf5Reader without(folder.file("without.h5"), "model");
    CHECK(without.number_attribute("/", "format_version") == version);
    CHECK_FALSE(without.has("/nodule"));
    CHECK(read_model(without).nodule.empty());
}

TEST_CASE("every nodule dataset has a rule and is refused in one line when made invalid", "[nodule]") {
    const TemporaryFolder folder;
    write_model(folder.file("whole.h5"), with_nodule(), by_test);
    for (const std::string dataset : {"/nodule/points", "/nodule/triangles"}) {
        REQUIRE_FALSE(rule_of(tissue_table(true), dataset).description.empty());
        CHECK(refused_mutations(folder.file("whole.h5"), tissue_table(true), [](const std::string& file) { read_model(file); }, "/",
                                [&](const std::string& altered) { return altered == dataset; }) > 5);
    }
}

TEST_CASE("a nodule that is open or inward or outside the tissue or too large is refused by name", "[nodule]") {
    const TemporaryFolder folder;
    const auto said = [&](const auto& change) {
        TissueModel model = with_nodule();
        change(model.nodule);
        write_model(folder.file("model.h5"), model, by_test);
        return refusal<FileError>([&] { read_model(folder.file("model.h5")); });
    };
    CHECK_THAT(said([](NoduleSurface& n) { n.triangles.conservativeResize(n.triangles.rows() - 1, 3); }), Contains("/nodule/triangles: are not closed"));
    CHECK_THAT(said([](NoduleSurface& n) { n.triangles.col(0).swap(n.triangles.col(1)); }), Contains("/nodule/triangles: have inward normals"));
    CHECK_THAT(said([](NoduleSurface& n) { n.points.col(2).array() += 0.1; }), Contains("/nodule/points: point 0 is outside the tissue"));
    CHECK_THAT(said([](NoduleSurface& n) { n.points = n.points.row(0).replicate(20001, 1).eval(); }), Contains("/nodule/points: has 20001 points; at most 20000 are possible"));
}
