#include "example.h"

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "error.h"
#include "mesh/embedded_block.h"
#include "mesh/cells.h"
#include "springs/energy_model_terms.h"
#include "springs/equilibrium.h"
#include "springs/heuristic.h"
#include "train/train_sets.h"

namespace tissue {

TemporaryFolder::TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "tissue_test_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::string TemporaryFolder::file(const std::string& name, const std::string& text) const {
    std::ofstream(file(name), std::ios::binary) << text;
    return file(name);
}

std::vector<std::string> TemporaryFolder::names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
}

const std::string& example_study_text() {
    static const std::string text = R"([geometry]
width_m = 0.1
height_m = 0.1
thickness_m = 0.0003

[material]
law = "mooney-rivlin"
C1_Pa = 263.0
C2_Pa = 491.0
density_kg_m3 = 1040.0
formulation = "plane-stress"

[lattice]
cells = [4, 4]

[mesh]
refine = 1

[indenter]
kind = "point"

[solver]
tolerance = 1e-10
max_newton = 12

[loads]
magnitudes_m = [0.004, 0.008]
record_step_m = 0.002
paths = [
  { name = "left", contact_m = [0.0, 0.05], push = [1, 0] },
  { name = "corner", contact_m = [0.1, 0.1], push = [-3, -1] },
]

[springs]
topology = "grid8"
law = "axial"

[training]
optimizer = "spsa"
also = ["spsa-2008"]
seed = 11
iterations = 200
k_min_E2 = 0.05
k_max_E2 = 40.0
weight_near = [0.95, 0.99]
weight_far = [0.80, 0.90]
)";
    return text;
}

std::string with(const std::string& text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    REQUIRE(text.find(from, at + 1) == std::string::npos);
    return text.substr(0, at) + to + text.substr(at + from.size());
}

Study example_study(const std::string& text) {
    const TemporaryFolder folder;
    return read_study(folder.file("example.toml", text));
}

Eigen::VectorXd example_theta(const SpringMesh& mesh) {
    Eigen::VectorXd theta = heuristic_stiffness(mesh, 1.0);
    for (int s = 0; s < theta.size(); ++s) theta[s] *= 1 + 0.5 * std::sin(1.7 * s);
    return theta;
}

Cases example_cases(const Study& study, const Eigen::VectorXd& theta) {
    const SpringMesh mesh = make_lattice("grid8", study.cells[0], study.cells[1], study.geometry.width_m,
                                         study.geometry.height_m);
    const auto law = make_spring_law("axial");
    Cases cases{study.name, mesh.nodes, {}, study.loads.magnitudes_m, {}};
    for (const StudyPath& p : study.loads.paths) {
        LoadPath path;
        path.name = p.name;
        path.contact_m = p.contact_m;
        path.direction = p.direction;
        path.depth_m = study.loads.depth_m();
        for (int r = 0; r <= study.loads.records(); ++r) {
            const double s = r == study.loads.records() ? study.loads.depth_m() : r * study.loads.record_step_m;
            const auto state = solve_equilibrium(mesh, *law, theta, locate_on_surface(mesh, p.contact_m),
                                                 p.direction * s);
            REQUIRE(state);
            PathRecord record{s,      state.displacement, NodeField::Zero(mesh.node_count(), 2), state.contact_force,
                              Eigen::Vector2d(0, 0), 0,                   1 - s,                                 r,
                              1e-12 * r};
            const Eigen::VectorXd f = law->force_matrix(mesh, record.displacement) * theta;
            record.force = Eigen::Map<const NodeField>(f.data(), mesh.node_count(), 2);
            for (int node : mesh.fixed) record.support_force_N += record.force.row(node).transpose();
            record.energy_J = f.dot(as_vector(record.displacement)) / 2;
            path.records.push_back(record);
        }
        cases.paths.push_back(path);
    }
    return cases;
}

LoadPath path_as_solved(const PlannedPath& planned, const std::function<NodeField(int)>& u) {
    LoadPath path;
    path.name = planned.push.name;
    path.contact_m = planned.push.contact_m;
    path.direction = planned.push.direction;
    path.role = planned.role;
    path.depth_m = planned.depth_m;
    for (int r = 0; r <= planned.records; ++r) {
        const NodeField moved = u(r);
        path.records.push_back({planned.depth_m * r / planned.records, moved, 2 * moved, planned.push.direction * r, planned.push.direction * -r, 0.1 * r, 1 - 0.01 * r, r, 1e-12});
    }
    return path;
}

void read_load_cases(const std::string& file) {
    const Cases cases = read_cases(file);
    try {
        load_cases(cases);
    } catch (const MismatchError&) {
    }
}

TrainedModel example_model(const Study& study, const Cases& cases, const Eigen::VectorXd& theta) {
    TrainedModel model = train_sets(study, cases, 1);
    for (SpringSets& t : model.trained) t.theta = theta.transpose().replicate(t.theta.rows(), 1);
    return model;
}

TissueModel solid_example() {
    constexpr double modulus_Pa = 4524, radius_m = 0.012;
    TissueModel m;
    m.study = "solid";
    m.law = "geometric";
    m.mesh = embedded_block(Lattice{{4, 4, 2}, {0.1, 0.1, 0.05}});
    m.modulus_N_m = modulus_Pa;
    m.node_mass_kg = node_masses(m.mesh, 1040, 1);
    m.heuristic_a = heuristic_stiffness(m.mesh, modulus_Pa);
    m.heuristic_b = m.heuristic_a / 6;
    const Eigen::VectorXd springs = Eigen::VectorXd::Constant(m.mesh.spring_count(), modulus_Pa),
                          cells = Eigen::VectorXd::Constant(mesh_cells(m.mesh).rows(), modulus_Pa);
    const EnergyModelTerms model_terms(m.mesh, solid_heuristic(m.mesh, springs, cells, modulus_Pa, 12, radius_m),
                        {"spring.all", "spring.face", "contact.normal.edge", "contact.tangent.edge", "contact.imprint_normal", "contact.hardening", "skin.tangent", "skin.radial"});
    const Eigen::VectorXd p = (Eigen::VectorXd(8) << -0.7, 0.9, 0.3, -0.2, 1.5, 1.2, -0.4, 0.3).finished();
    m.energy_model = {model_terms.terms(), p, model_terms.constants(p), model_terms.patch(p), model_terms.incompressible(), radius_m};
    m.energy_model->curve = SpringCurve::mooney_rivlin(0.2, 3);
    m.case_names = {"down-3mm", "tilted-5mm"};
    m.contact_m.resize(2, 3);
    m.contact_m << 0.05, 0.05, 0.05, 0.041, 0.058, 0.05;
    m.direction.resize(2, 3);
    m.direction << 0, 0, -1, 0.3, 0.4, -std::sqrt(0.75);
    m.magnitude_m = Eigen::Vector2d(0.003, 0.005);
    return m;
}

void replace_dataset(const std::string& file, const std::string& dataset, const std::vector<double>& values) {
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    REQUIRE(H5Ldelete(id, dataset.c_str(), H5P_DEFAULT) >= 0);
    if (!values.empty()) {
        const hsize_t count = values.size();
        const hid_t space = H5Screate_simple(1, &count, nullptr);
        const hid_t made = H5Dcreate2(id, dataset.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT,
                                      H5P_DEFAULT);
        H5Dwrite(made, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
        H5Dclose(made);
        H5Sclose(space);
    }
    H5Fclose(id);
}

NodeField scattered(const SpringMesh& mesh, double size_m) {
    NodeField u(mesh.node_count(), mesh.dimension());
    for (Eigen::Index i = 0; i < u.size(); ++i)
        u.data()[i] = size_m * std::sin(12.9898 * static_cast<double>(i + 1) + 78.233);
    return u;
}

}  // namespace tissue
