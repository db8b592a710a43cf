#include "export/energy_model_tables.h"

#include <fmt/format.h>

#include <array>

#include "error.h"
#include "mesh/cells.h"
#include "springs/region_area.h"

namespace tissue {
namespace {

/// Node pairs around an element that preserves its area, with the area on the left.
std::vector<std::array<int, 2>> outline(const Elements& kind, int e) {
    const Cells& nodes = kind.nodes();
    std::vector<std::array<int, 2>> pairs;
    if (const auto* region = dynamic_cast<const RegionArea*>(&kind)) {
        for (const auto& [i, j] : region->edges()) pairs.push_back({nodes(e, i), nodes(e, j)});
    } else {
        for (Eigen::Index k = 0; k < nodes.cols(); ++k)
            pairs.push_back({nodes(e, k), nodes(e, (k + 1) % nodes.cols())});
    }
    return pairs;
}

}  // namespace

EnergyModelTables energy_model_tables(const TissueModel& model) {
    const SpringMesh& mesh = model.mesh;
    const EnergyModel& energy_model = *model.energy_model;
    const TissueEnergy energy(mesh, energy_model);
    const int S = mesh.spring_count(), areas = energy.constant_count() - S;
    const auto regions = static_cast<int>(energy_model.incompressible ? cell_regions(mesh, mesh_cells(mesh)).size() : 0);
    const Outline surface(mesh);
    EnergyModelTables t;
    t.curve = energy_model.curve;
    t.spring_N_m = energy_model.constants.head(S);
    t.area_N_m = energy_model.constants.tail(areas);
    t.area_m2 = Eigen::VectorXd::Zero(areas);
    t.surface_node = surface.nodes();
    t.surface_arc_m = surface.arcs();
    for (const int node : t.surface_node) t.surface_log_scale.push_back(energy_model.contact_log_scale.size() > 0 ? energy_model.contact_log_scale[node] : 0);
    for (int area = 0; area < areas; ++area) t.area_kind.push_back(area < areas - regions ? "cell" : "region");
    for (std::size_t k = 1; k < energy.kinds().size(); ++k)  // springs are the first
        for (int e = 0; e < energy.kinds()[k]->count(); ++e) {
            const int area = energy.first_of(k) + e - S;
            for (const auto& [i, j] : outline(*energy.kinds()[k], e)) {
                t.edge_area.push_back(area);
                t.edge_from.push_back(i);
                t.edge_to.push_back(j);
                t.area_m2[area] += (mesh.nodes(i, 0) * mesh.nodes(j, 1) - mesh.nodes(j, 0) * mesh.nodes(i, 1)) / 2;
            }
        }
    return t;
}

std::vector<IndentationOfCase> indentations_of_cases(const TissueModel& model, const std::string& name) {
    const IndentationSolver solver(model);
    const TissueEnergy energy(model.mesh, *model.energy_model);
    std::optional<Outline> surface;
    if (!model.mesh.is_solid()) surface.emplace(model.mesh);
    std::vector<IndentationOfCase> cases;
    for (int c = 0; c < model.case_count(); ++c) {
        if (!name.empty() && model.case_names[static_cast<std::size_t>(c)] != name) continue;
        const Point contact_m = model.contact_m.row(c).transpose(), push_m = model.magnitude_m[c] * model.direction.row(c).transpose();
        const std::optional<double> arc_m = surface ? std::optional<double>(surface->arc_of(contact_m)) : std::nullopt;
        const Equilibrium state = solver.of(model.radius_of(c)).at(contact_m, push_m);
        cases.push_back({c, arc_m, push_m, state, energy.force(model.energy_model->constants, state.displacement)});
    }
    if (cases.empty())
        throw MismatchError(
            fmt::format("load case '{}' is not in the model; the model has {}", name,
                        model.case_count() > 0 ? "names such as " + model.case_names.front() : "none"));
    return cases;
}

}  // namespace tissue
