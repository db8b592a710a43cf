// Cases files, edited as in fuzz_model.cpp: of finite elements, of measurements, of a shape and in space.
#include "../mesh/embedded_block.h"
#include "cases/load_path.h"
#include "edited_store.h"
#include "fuzz_file.h"

using namespace tissue;

namespace {

NodeField some(Eigen::Index rows, Eigen::Index columns) {
    NodeField field(rows, columns);
    for (Eigen::Index i = 0; i < field.size(); ++i) field.data()[i] = 1e-3 * std::sin(1.7 * static_cast<double>(i) + 1);
    return field;
}

Cases cases_of(const SpringMesh& mesh, bool measured) {
    const Eigen::Index D = mesh.nodes.cols();
    Cases cases;
    cases.study = "example";
    cases.nodes = mesh.nodes;
    if (!measured) cases.magnitudes_m = {0.01};
    if (measured) cases.measurement = Measurement{"a bench", 2, 2, 0, 0, 0, "unknown", {"line 3"}};
    for (const char* name : {"left", "right"}) {
        LoadPath path;
        path.name = name;
        path.contact_m = mesh.nodes.row(mesh.nodes.rows() - 1).transpose();
        path.direction = -Point::Unit(D, D - 1);
        path.depth_m = 0.01;
        for (const double magnitude_m : {0.0, 0.01}) {
            PathRecord record = measured_record(magnitude_m, path.direction * magnitude_m, Point::Zero(D));
            if (!measured) {
                record.displacement = record.force = some(mesh.nodes.rows(), D);
                record.support_force_N = Point::Zero(D);
                record.smallest_J = 1;
                record.aside_m = {};
            }
            path.records.push_back(record);
        }
        cases.paths.push_back(path);
    }
    History h;
    h.name = "ramp-0001";
    h.group = h.kind = "ramp";
    h.role = "held_out";
    h.contact_m = cases.paths[0].contact_m;
    h.direction = cases.paths[0].direction;
    h.time_s = Eigen::Vector3d(0, 0.1, 0.2);
    h.push_m = h.force_N = some(3, D);
    h.push_m.row(0).setZero();
    h.elastic_N = h.force_N;
    h.contact = {1, 1, 1};
    cases.histories = {h};
    return cases;
}

EditedStore stored(const char* name, const Cases& cases) {
    const std::string file = base_file(name);
    write_cases(file, cases, {"fuzz", 0, {}});
    return EditedStore(file);
}

const std::vector<EditedStore>& bases() {
    static const std::vector<EditedStore> all = [] {
        const SpringMesh plane = make_lattice("grid4", 2, 2, 0.1, 0.1), space = embedded_block(Lattice{{1, 1, 1}, {0.1, 0.1, 0.05}});
        Cases shaped = cases_of(plane, false);
        shaped.shape = shape_of(plane);
        return std::vector<EditedStore>{stored("cases", cases_of(plane, false)), stored("measured", cases_of(plane, true)), stored("shape", shaped),
                                        stored("solid-cases", cases_of(space, false))};
    }();
    return all;
}

}  // namespace

FUZZ_TARGET(cases)(const std::uint8_t* data, std::size_t size) {
    Choices choices(data, size);
    EditedStore store = bases()[choices.below(bases().size())];
    for (int k = 0; k < 8 && choices.more(); ++k) store.edit(choices);
    const std::string file = FuzzFile::folder() + "/cases.h5";
    if (!reads([&] { store.write(file); })) return 0;
    reads([&] {
        const Cases cases = read_cases(file);
        load_cases(cases);
        without_mirrors(cases);
        if (cases.shape) edge_mesh(*cases.shape);
    });
    return 0;
}
