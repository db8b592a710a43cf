#include "eval/solid_force_table.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "../mesh/embedded_block.h"
#include "mesh/topology.h"
#include "../example.h"
#include "../mesh/dome.h"
#include "../solid_model_example.h"
#include "mesh/embedded_lattice.h"
#include "springs/supports.h"
#include "../tolerances.h"

using namespace tissue;

TEST_CASE("a force table in space reproduces a uniform stiffness and marks extrapolation", "[solid]") {
    const Eigen::Matrix3d S = (Eigen::Matrix3d() << 30, 2, 0, 2, 35, 1, 0, 1, 50).finished();
    std::vector<LoadPath> paths(6);
    std::vector<PathRecord> records(paths.size());
    std::vector<LoadCase> loads;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        paths[i].contact_m = Eigen::Vector3d(0.01 * static_cast<double>(i), 0.02, 0.05);
        paths[i].direction = Eigen::Vector3d(i % 2 ? 0.5 : 0, i % 3 ? 0.4 : 0, -1).normalized();
        records[i].magnitude_m = 0.004;
        records[i].contact_force_N = S * (0.004 * Eigen::Vector3d(paths[i].direction));
        loads.push_back({"", &paths[i], &records[i]});
    }
    const SolidForceTable table(table_pushes(loads));
    const Eigen::Vector3d direction = Eigen::Vector3d(0.2, 0.3, -1).normalized();
    const ForceTable::Entry near = table.at(Eigen::Vector3d(0.024, 0.021, 0.05), direction, 0.005);
    CHECK((near.force_N - S * (0.005 * direction)).norm() < 1e-3 * near.force_N.norm());
    CHECK_FALSE(near.extrapolated);
    // indentations by a disc of twice the radius to twice the depth have four times the force of this disc
    for (LoadPath& path : paths) path.radius_m = 0.014;
    for (PathRecord& record : records) {
        record.magnitude_m *= 2;
        record.contact_force_N *= 4;
    }
    const ForceTable::Entry scaled = SolidForceTable(table_pushes(loads, {}, 0.007)).at(Eigen::Vector3d(0.024, 0.021, 0.05), direction, 0.005);
    CHECK((scaled.force_N - near.force_N).norm() < 1e-12);
    CHECK(table.at(Eigen::Vector3d(0.024, 0.08, 0.05), direction, 0.005).extrapolated);
}

TEST_CASE("a square block has seven symmetries and an oblong one three; a nodule reduces them", "[solid]") {
    TissueModel model = solid_example();
    CHECK(symmetries_of(model).size() == 7);
    for (const Symmetry& s : symmetries_of(model)) {
        CHECK((s.turn * s.turn.transpose() - Eigen::Matrix3d::Identity()).norm() <= tolerance::rounding);
        for (Eigen::Index i = 0; i < model.mesh.nodes.rows(); ++i) {  // every node maps to a node
            const Point image = s.centre_m + s.turn * (model.mesh.nodes.row(i).transpose() - s.centre_m);
            CHECK((model.mesh.nodes.rowwise() - image.transpose()).rowwise().norm().minCoeff() <= tolerance::rounding);
        }
    }
    TissueModel nodule = model;
    nodule.energy_model->disc.ground = Eigen::RowVector4d(0.02, 0.03, 0.03, 1e-8);
    CHECK(symmetries_of(nodule).empty());
    const Point low = model.mesh.own_nodes().colwise().minCoeff().transpose(), high = model.mesh.own_nodes().colwise().maxCoeff().transpose(), middle = (low + high) / 2;
    NodeField& ground = nodule.energy_model->disc.ground;
    ground.row(0) << middle[0], middle[1], 0.03, 1e-8;  // on the block's axis
    CHECK(symmetries_of(nodule).size() == 7);
    ground(0, 1) += 0.01;  // off the axis: only the reflection in x
    REQUIRE(symmetries_of(nodule).size() == 1);
    CHECK(symmetries_of(nodule)[0].turn == Eigen::Matrix3d(Eigen::Vector3d(-1, 1, 1).asDiagonal()));
    ground.conservativeResize(2, 4);
    // two equal points: the reflections in x, in y and in both
    ground.row(1) << middle[0], middle[1] - 0.01, 0.03, 1e-8;
    CHECK(symmetries_of(nodule).size() == 3);
    ground(1, 3) = 2e-8;  // two points of different stiffness
    CHECK(symmetries_of(nodule).size() == 1);
    const SpringMesh oblong = embedded_block(Lattice{{5, 4, 2}, {0.125, 0.1, 0.05}});
    model.mesh = oblong;
    model.energy_model->constants.tail(oblong.support_count()) = fixed_areas(oblong);
    CHECK(symmetries_of(model).size() == 3);
    TissueModel uneven = model;  // supports of two stiffnesses
    uneven.energy_model->constants.tail(1) *= 2;
    CHECK(symmetries_of(uneven).empty());
    SpringMesh aside = oblong;  // fixed not only at the bottom
    aside.fixed.push_back(aside.embedding.node_count() - 1);
    TissueModel other = model;
    other.mesh = aside;
    CHECK(symmetries_of(other).empty());
    CHECK(symmetries_of(solid_model_example(embedded_lattice(dome(6), 0.011))).empty());
    model.mesh = make_lattice("grid8", 4, 4, 0.1, 0.1);
    model.energy_model.reset();
    REQUIRE(symmetries_of(model).size() == 1);
    CHECK(symmetries_of(model)[0].turn == Eigen::Matrix2d(Eigen::Vector2d(-1, 1).asDiagonal()));
}

TEST_CASE("a force table in space returns the image force at every symmetric image of an indentation", "[solid]") {
    const TissueModel model = solid_example();
    LoadPath path;
    path.contact_m = Eigen::Vector3d(0.02, 0.035, 0.05);
    path.direction = Eigen::Vector3d(0.5, 0.2, -1).normalized();
    PathRecord record;
    record.magnitude_m = 0.004;
    record.contact_force_N = Eigen::Vector3d(0.1, 0.05, -0.4);
    const std::vector<TablePush> pushes = table_pushes({{"", &path, &record}}, symmetries_of(model));
    REQUIRE(pushes.size() == 8);
    const SolidForceTable table(pushes);
    for (const TablePush& image : pushes) {
        const ForceTable::Entry at = table.at(image.contact_m, image.direction, 0.004);
        CHECK((at.force_N - image.force_N).norm() < 0.01 * image.force_N.norm());
        CHECK_FALSE(at.extrapolated);
    }
    // the reflection in x
    CHECK((pushes[1].force_N - Eigen::Vector3d(-0.1, 0.05, -0.4)).norm() <= tolerance::rounding);

    PathRecord again = record;  // measured twice: both measurements have their images
    again.contact_force_N *= 1.1;
    const std::vector<TablePush> repeated = table_pushes({{"", &path, &record}, {"", &path, &again}}, symmetries_of(model));
    CHECK(repeated.size() == 16);
    for (const double z_N : {-0.4, -0.44})
        CHECK(std::count_if(repeated.begin(), repeated.end(), [&](const TablePush& p) { return std::abs(p.force_N.z() - z_N) < 1e-9; }) == 8);

    path.contact_m = Eigen::Vector3d(0.05, 0.05, 0.05);  // normal in the middle: all its images are itself
    path.direction = Eigen::Vector3d(0, 0, -1);
    CHECK(table_pushes({{"", &path, &record}}, symmetries_of(model)).size() == 1);
    CHECK(table_pushes({{"", &path, &record}, {"", &path, &again}}, symmetries_of(model)).size() == 2);
}
