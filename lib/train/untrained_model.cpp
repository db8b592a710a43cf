#include "train/untrained_model.h"

#include <fmt/format.h>

#include "cases/study_energy_model.h"
#include "cases/study_mesh.h"
#include "error.h"
#include "springs/heuristic.h"

namespace tissue {

SpringMesh spring_mesh_of(const Study& study, const Cases& cases) {
    SpringMesh mesh = study_mesh(study, cases.shape, study.springs.topology);
    if (!has_nodes(mesh, cases.nodes))
        throw MismatchError(fmt::format("the cases have {} nodes, which are not those of the {} x {} lattice of study '{}'",
                                        cases.nodes.rows(), study.cells[0] + 1, study.cells[1] + 1, study.name));
    return mesh;
}

namespace {

/// (7) with this E2 for the base material, and in proportion to E in regions or a nodule of another material.
Eigen::VectorXd study_heuristic(const Study& study, const Cases& cases, const SpringMesh& mesh, double modulus_N_m) {
    if (mesh.is_solid() && (study.nodule || !study.material.regions.empty()))
        return heuristic_stiffness(mesh, modulus_N_m / study.modulus_N_m()).cwiseProduct(solid_moduli(study, cases.shape, mesh, mesh.springs));
    if (study.material.regions.empty()) return heuristic_stiffness(mesh, modulus_N_m);
    return heuristic_stiffness(mesh, triangle_moduli(study, cases.shape, mesh, modulus_N_m));
}

}  // namespace

TrainedModel untrained_model(const Study& study, const Cases& cases, const std::vector<LoadCase>& loads) {
    TrainedModel model;
    model.books.seed = study.training.seed;
    model.study = study.name;
    model.law = study.springs.law;
    model.mesh = spring_mesh_of(study, cases);
    if (study.nodule && model.mesh.is_solid()) model.nodule = nodule_surface(study.nodule->inclusion);
    model.modulus_N_m = study.modulus_N_m();
    model.node_mass_kg = node_masses(model.mesh, study.material.density_kg_m3, study.geometry.thickness_m);
    model.heuristic_a = study_heuristic(study, cases, model.mesh, study.modulus_N_m());
    model.heuristic_b = study_heuristic(study, cases, model.mesh, study.second_modulus_N_m());

    const auto C = static_cast<Eigen::Index>(loads.size());
    const int D = model.mesh.dimension();
    model.contact_m.resize(C, D);
    model.direction.resize(C, D);
    model.magnitude_m.resize(C);
    model.contact_force_N.resize(C, D);
    for (Eigen::Index c = 0; c < C; ++c) {
        const LoadCase& load = loads[static_cast<std::size_t>(c)];
        model.case_names.push_back(load.name);
        model.contact_m.row(c) = load.path->contact_m;
        model.direction.row(c) = load.path->direction;
        model.magnitude_m[c] = load.record->magnitude_m;
        model.contact_force_N.row(c) = load.record->contact_force_N;
    }
    if (std::any_of(loads.begin(), loads.end(), [](const LoadCase& load) { return load.path->radius_m > 0; })) {
        model.case_radius_m.resize(C);
        for (Eigen::Index c = 0; c < C; ++c) {
            const double radius_m = loads[static_cast<std::size_t>(c)].path->radius_m;
            model.case_radius_m[c] = radius_m > 0 ? radius_m : cases.disc_radius_m;
        }
    }
    return model;
}

std::string nothing_to_train_on(const Cases& cases) {
    constexpr int shown = 3;
    int count = 0;
    std::string text;
    for (const LoadPath& path : without_mirrors(cases).paths) {
        if (path.role != "train" || path.lost.empty()) continue;
        if (++count > shown) continue;
        std::string place;
        for (double x : path.contact_m) place += fmt::format("{}{:.4g}", place.empty() ? "" : ", ", 1e3 * x);
        text += fmt::format("; {} at ({}) mm, {:.3g} mm deep: {}", path.name, place, 1e3 * path.depth_m, path.lost.substr(0, path.lost.find(';')));
    }
    if (count == 0) return fmt::format("the cases of study '{}' have no training path", cases.study);
    return fmt::format("study '{}': none of its {} training paths has an FE reference up to its first load case, so there is nothing to train on{}{}", cases.study, count, text,
                       count > shown ? fmt::format("; and {} more", count - shown) : "");
}

}  // namespace tissue
