#include "export/solid_model_tables.h"

#include <array>
#include <map>

#include "springs/cell_volumes.h"
#include "springs/contact_errors.h"
#include "springs/contact_spring.h"
#include "springs/energy_model_at_radius.h"
#include "springs/energy_model_kernel.h"

namespace tissue {

SolidModelTables solid_model_tables(const TissueModel& model) {
    const SpringMesh& mesh = model.mesh;
    const Eigen::VectorXd& constants = model.energy_model->constants;
    const CellVolumes cells(mesh);
    return {model.energy_model->curve, constants.head(mesh.spring_count()), cells.nodes(), mesh.embedding.centroid, cells.volumes(), constants.segment(mesh.spring_count(), cells.count()), constants.tail(mesh.support_count())};
}

ContactTable contact_table(const TissueModel& model, const std::vector<int>& load_cases) {
    constexpr const char* kinds[] = {"normal", "tangent", "imprint_normal", "imprint_tangent"};
    struct Disc {
        EnergyModel energy_model;
        std::unique_ptr<ContactKernel> kernel;
    };
    std::map<double, Disc> discs;  // by radius
    ContactTable table;
    std::vector<std::array<double, 3>> push, pull;
    std::vector<std::array<double, 4>> hardening;
    for (const int c : load_cases) try {
            const double radius_m = model.radius_of(c);
            Disc& disc = discs[radius_m];
            if (!disc.kernel) {
                disc.energy_model = energy_model_at_radius(*model.energy_model, radius_m);
                disc.kernel = make_contact_kernel(model.mesh, disc.energy_model);
            }
            const ContactSpring contact(disc.kernel->rows_at(model.contact_m.row(c).transpose()), disc.energy_model.patch);
            const ContactRows& rows = contact.rows;
            for (Eigen::Index r = 0; r < contact.k_N_m.size(); ++r) {
                for (std::size_t i = 0; i < rows.nodes.size(); ++i) {
                    const auto part = rows.pull.block<1, 3>(r, 3 * static_cast<Eigen::Index>(i));
                    if (part.isZero(0)) continue;
                    table.pull_row.push_back(static_cast<int>(table.load_case.size()));
                    table.pull_node.push_back(rows.nodes[i]);
                    pull.push_back({part[0], part[1], part[2]});
                }
                push.push_back({rows.push(r, 0), rows.push(r, 1), rows.push(r, 2)});
                table.load_case.push_back(c);
                table.kind.push_back(kinds[rows.parameter_row[static_cast<std::size_t>(r)]]);
                table.k_N_m.push_back(contact.k_N_m[r]);
            }
            hardening.push_back({contact.hardening_1_J, contact.saturation_1_J, contact.coupling_N_m2, contact.curve == ContactCurve::compression ? 1.0 : 0.0});
        } catch (const NoContactError&) {
            hardening.push_back({0, 0, 0, 0});
        }
    const auto field = [](const auto& rows) {
        using Row = typename std::decay_t<decltype(rows)>::value_type;
        NodeField out(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(std::tuple_size<Row>::value));
        for (std::size_t r = 0; r < rows.size(); ++r)
            for (std::size_t k = 0; k < rows[r].size(); ++k) out(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(k)) = rows[r][k];
        return out;
    };
    table.push = field(push);
    table.pull = field(pull);
    table.hardening = field(hardening);
    return table;
}

}  // namespace tissue
