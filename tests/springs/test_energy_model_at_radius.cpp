// An energy model in space under discs of other radii than its own.
#include "springs/energy_model_at_radius.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "../example.h"
#include "../format_version.h"
#include "../mesh/embedded_block.h"
#include "../refusal.h"
#include "../solid_model_example.h"
#include "several_discs.h"
#include "../tolerances.h"
#include "error.h"
#include "haptic/simulation.h"
#include "io/hdf5_store.h"
#include "mesh/topology.h"
#include "parallel.h"
#include "springs/disc_rows.h"
#include "springs/energy_model_terms.h"
#include "springs/energy_model_kernel.h"
#include "springs/indentation_solver.h"
#include "version.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

constexpr double own_m = 0.007;
const Eigen::Vector3d place(0.021, 0.033, 0.02), inward(0, 0, -1);

}  // namespace

TEST_CASE("with_means inserts the geometric mean between neighbouring radii") {
    const Eigen::VectorXd radii_m = with_means({0.004, 0.009, 0.010});
    REQUIRE(radii_m.size() == 5);
    CHECK(radii_m[0] == 0.004);
    CHECK(radii_m[1] == Approx(0.006).epsilon(tolerance::rounding));
    CHECK(radii_m[2] == 0.009);
    CHECK(radii_m[4] == 0.010);
    CHECK(with_means({0.007}) == Eigen::VectorXd::Constant(1, 0.007));
}

TEST_CASE("contact parameters at another radius are its start values plus size terms and its correction", "[solid]") {
    const TissueModel model = several_discs();
    const EnergyModel &energy_model = *model.energy_model, same = energy_model_at_radius(energy_model, own_m), none = energy_model_at_radius(energy_model, 0);
    CHECK(same.patch.log_N_m == energy_model.patch.log_N_m);
    CHECK(none.sizes.radii_m == energy_model.sizes.radii_m);
    const EnergyModel large = energy_model_at_radius(energy_model, 0.010);
    const double x = std::log(0.010 / own_m);
    const Eigen::VectorXd grown = (large.patch.log_N_m - energy_model.patch.log_N_m).col(0);
    const Eigen::VectorXd start = start_of_disc(4500, 0.010, 0.010) - start_of_disc(4500, own_m, 0.010);
    CHECK((grown - start - x * (Eigen::VectorXd(7) << 0.3, 0, 0, 0, 1.5, 0, 0).finished()).norm() < 1e-12);
    CHECK((large.patch.log_N_m - energy_model.patch.log_N_m).rightCols(3).isZero(0));
    // as in training
    CHECK(large.patch.log_N_m == resized(energy_model.patch, energy_model.terms, energy_model.coefficients, 0.007, 0.010, x).log_N_m);
    CHECK((energy_model_of_contact(energy_model, 0.010).patch.log_N_m - large.patch.log_N_m).isZero(1e-12));  // as in the tick
    CHECK((energy_model_of_contact(energy_model, 0.005).patch.log_N_m - energy_model_at_radius(energy_model, 0.005).patch.log_N_m).isZero(1e-12));
    // below the range of the training discs the size terms are constant
    const Eigen::VectorXd small = energy_model_of_contact(energy_model, 0.001).patch.log_N_m.col(0) - energy_model_of_contact(energy_model, 0.002).patch.log_N_m.col(0);
    CHECK((small - (start_of_disc(4500, 0.001, 0.010) - start_of_disc(4500, 0.002, 0.010))).isZero(1e-12));
    CHECK(large.disc_radius_m == 0.010);
    CHECK(large.disc.correction.value.isConstant(0.06, 1e-12));
    CHECK(large.constants == energy_model.constants);
    CHECK(large.sizes.empty());
    // between two radii the correction is linear in the logarithm of the radius
    const double between = std::exp(0.25 * std::log(0.004) + 0.75 * std::log(energy_model.sizes.radii_m[1]));
    CHECK(energy_model_at_radius(energy_model, between).disc.correction.value.isConstant(-0.05 + 0.75 * 0.08, 1e-12));

    CHECK_THAT(refusal<MismatchError>([&] { energy_model_at_radius(energy_model, 0.0039); }), Contains("3.9 mm") && Contains("discs from 4 to 10 mm"));
    CHECK_THAT(refusal<MismatchError>([&] { energy_model_at_radius(energy_model, 0.0101); }), Contains("10.1 mm"));
    CHECK_THROWS_AS(energy_model_at_radius(energy_model, std::nan("")), MismatchError);
    CHECK_THAT(refusal<MismatchError>([&] { energy_model_at_radius(*solid_model_example(model.mesh).energy_model, 0.006); }), Contains("only a disc of 7 mm"));
}

TEST_CASE("IndentationSolver of another disc is that of the model at its radius and is made once for all threads", "[solid]") {
    const TissueModel model = several_discs();
    const IndentationSolver solver(model);
    CHECK(&solver.of(0) == &solver);
    CHECK(&solver.of(own_m) == &solver);
    std::array<const IndentationSolver*, 4> made{};
    parallel_for(4, 4, [&](int i) { made[static_cast<std::size_t>(i)] = &solver.of(0.005); });
    const IndentationSolver& other = *made[0];
    for (const IndentationSolver* one : made) CHECK(one == &other);
    const Equilibrium here = other.at(place, 0.002 * inward), there = IndentationSolver(with_tool(model, {ToolChoice::Shape::disc, 0.005})).at(place, 0.002 * inward);
    REQUIRE(here);
    CHECK(here.contact_force == there.contact_force);
    CHECK(here.contact_force.norm() < 0.9 * solver.at(place, 0.002 * inward).contact_force.norm());
    CHECK_THROWS_AS(solver.of(0.02), MismatchError);
}

TEST_CASE("derivatives of contact parameters by size terms agree with finite differences", "[solid]") {
    const SpringMesh mesh = embedded_block(Lattice{{4, 4, 2}, {0.04, 0.04, 0.02}});
    const std::string hardens = GENERATE("contact.hardening.size", "contact.compression.size", "contact.softening.size");
    const EnergyModelTerms model_terms(mesh, solid_heuristic(mesh, Eigen::VectorXd::Constant(mesh.spring_count(), 4500), Eigen::VectorXd::Constant(mesh_cells(mesh).rows(), 4500), 4500, 12, own_m),
                        {"contact.normal", "contact.normal.size", hardens, "contact.coupling.size"});
    const Eigen::VectorXd p = Eigen::Vector4d(0.2, 0.4, -0.7, 0.3);
    const ContactFactors factors = ContactFactors(1, 0.2, 0, 0.5);
    const double log_times = std::log(1.4);
    const Eigen::MatrixXd by = model_terms.stiffness_by(p, factors, 0.1, log_times);
    for (int t = 0; t < model_terms.size(); ++t) {
        const Eigen::VectorXd e = 1e-5 * Eigen::VectorXd::Unit(model_terms.size(), t);
        const Eigen::VectorXd difference = (model_terms.patch(p + e, log_times).values_at(factors, 0.1) - model_terms.patch(p - e, log_times).values_at(factors, 0.1)) / 2e-5;
        CHECK((by.col(t) - difference).norm() <= 1e-8 * difference.norm());
    }
    const Eigen::VectorXd grown = model_terms.patch(p, log_times).log_N_m.col(0) - model_terms.patch(p).log_N_m.col(0);
    const Eigen::VectorXd start = start_of_disc(4500, 1.4 * own_m, 0.010) - start_of_disc(4500, own_m, 0.010);
    CHECK((grown - start - log_times * (Eigen::VectorXd(7) << 0.4, 0, 0, 0, -0.7, 0, 0.3).finished()).norm() < 1e-12);
}

TEST_CASE("an energy model for several discs is read back unchanged; contradictory datasets are refused", "[solid]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5");
    const TissueModel model = several_discs();
    const auto refused = [&](auto&& change) {
        TissueModel changed = model;
        change(changed);
        write_model(file, changed, {"tissuectl test", 0, {}});
        return refusal<FileError>([&] { read_model(file); });
    };
    write_model(file, model, {"tissuectl test", 0, {}});
    CHECK(Hdf5Reader(file, "model").number_attribute("/", "format_version") == curve_format_version);
    set_format_version(file, radii_format_version);
    CHECK_THAT(refusal<FileError>([&] { read_model(file); }), Contains("/law/radii") && Contains("train the model again"));
    set_format_version(file, rows_format_version);
    const TissueModel back = read_model(file);
    CHECK(back.energy_model->sizes.radii_m == model.energy_model->sizes.radii_m);
    REQUIRE(back.energy_model->sizes.correction.size() == 5);
    CHECK(back.energy_model->sizes.correction[4].value == model.energy_model->sizes.correction[4].value);
    CHECK(back.case_radius_m[0] == 0.004);
    CHECK_FALSE(back.is_own_case(0));
    CHECK(back.deepest_m() == Approx(0.006 * 7 / 4));  // proportional to the radius
    CHECK(with_tool(back, {ToolChoice::Shape::disc, 0.005}).deepest_m() == Approx(0.006 * 5 / 4));
    CHECK(energy_model_at_radius(*back.energy_model, 0.005).patch.log_N_m == energy_model_at_radius(*model.energy_model, 0.005).patch.log_N_m);

    CHECK_THAT(refused([](TissueModel& m) { m.energy_model->sizes.radii_m[2] = 0.0071; }), Contains("/law/radii") && Contains("disc_radius_m"));
    CHECK_THAT(refused([](TissueModel& m) { m.energy_model->sizes.correction.pop_back(); }), Contains("/law/radius_corrections") && Contains("must"));
    CHECK_THAT(refused([](TissueModel& m) { m.energy_model->sizes.correction.clear(); }), Contains("/law/radius_corrections") && Contains("belong together"));
    CHECK_THAT(refused([](TissueModel& m) { m.case_radius_m[0] = 0.011; }), Contains("/cases/radius") && Contains("outside the range"));
    CHECK_THAT(refused([](TissueModel& m) { m.case_radius_m.resize(0); }), Contains("/cases/radius") && Contains("belong together"));
    TissueModel alone = model;
    alone.energy_model->sizes = {};
    alone.case_radius_m.resize(0);
    write_model(file, alone, {"tissuectl test", 0, {}});
    CHECK(Hdf5Reader(file, "model").number_attribute("/", "format_version") == curve_format_version);
    CHECK(read_model(file).energy_model->sizes.empty());
}

TEST_CASE("a session simulates a disc of another radius as with_tool makes it", "[solid][simulation]") {
    const TissueModel model = several_discs();
    HapticOptions options;
    options.heuristic_mesh = false;
    options.tool = {{ToolChoice::Shape::disc, 0.005}};
    const TissueModel other = with_tool(model, {ToolChoice::Shape::disc, 0.005});
    const HapticModel small(model, options), own(model, {});
    CHECK(small.fingerprint != own.fingerprint);
    Simulation simulation(small);
    DeviceSample sample;
    for (int k = 0; k < 4000; ++k) {
        sample.position_m = place + std::min(0.002, -0.002 + 1e-5 * k) * inward;
        simulation.tick(sample);
    }
    const TickRecord& r = simulation.record();
    const Equilibrium rest = IndentationSolver(other).at(small.meshes[0]->springs.rest_place(r.facet, r.weight), r.contact_displacement_m);
    REQUIRE(rest);
    CHECK((r.coupling_N + rest.contact_force).norm() < 2e-3 * rest.contact_force.norm());
    options.tool = {{ToolChoice::Shape::disc, 0.02}};
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(model, options); }), Contains("a disc of radius 20 mm") && Contains("from 4 to 10 mm"));
    CHECK(with_tool(model, {ToolChoice::Shape::disc, 0}).energy_model->sizes.radii_m == model.energy_model->sizes.radii_m);
    CHECK_FALSE(other.is_own_case(0));
    CHECK(with_tool(model, {ToolChoice::Shape::disc, 0.004}).is_own_case(0));
}
