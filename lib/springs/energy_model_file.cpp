#include "springs/energy_model_file.h"

#include <fmt/format.h>

#include <cmath>

#include "error.h"
#include "springs/energy_model_terms.h"
#include "springs/tissue_energy.h"
#include "springs/tissue_table.h"
#include "springs/tool_spring.h"
#include "version.h"

namespace tissue {

const DatasetTable& energy_model_table(bool solid) {
    static const DatasetTable plane = {
        {"/law/terms", "P", Values::names(), "text", "names of the terms"},
        {"/law/coefficients", "P", Values::logarithm(), "1", "coefficient of each term"},
        {"/law/constants", "E", Values::positive(), "N/m", "theta of the springs, then A of cells and regions, in space Pa"},
        {"/law/patch_log", "K x F", Values::logarithm(), "log(N/m)",
         "contact: normal, tangent, rotation, stretch, of a disc normal, tangent, imprint_normal, imprint_tangent, hardening, saturation, coupling; "
         "by 1, phase (for a disc curved), corner (for a disc ground), edge"},
        {"/law/contact_log_scale", "N", Values::logarithm(), "1", "log factor of the contact by node, in an adapted model", Rows::any, true},
        {"/law/relaxation_time", "B", Values::positive(), "s", "relaxation time of each Maxwell branch; absent if the model does not relax", Rows::ascending, true},
        {"/law/share", "E x B", Values::not_negative(), "1", "relative moduli of each constant, sums below 1", Rows::any, true},
        {"/law/contact_share", "B", Values::not_negative(), "1", "relative moduli of the contact", Rows::any, true},
    };
    static const DatasetTable space = joined(plane, {
        {"/law/ground", "G x 4", Values::place(), "m, m3", "tissue of other stiffness, for the term ground: place, volume times log(E / E_block)", Rows::any, true},
        {"/law/curved_range", "R", Values::finite(), "1", "range of the factor curved over the training contacts, to which that of a contact is clamped", Rows::any, true},
        {"/law/radii", "Y", Values::positive(), "m", "disc radii of the training, the model's own among them (springs/disc_sizes.h)", Rows::ascending, true},
        {"/law/radius_corrections", "Q x V", Values::logarithm(), "1", "lattice_correction of each of these discs, one after the other: Q = Y T", Rows::any, true},
        {"/law/lattice_correction", "T x V", Values::logarithm(), "1", "log factor of contacts at V corners of equal parts of each facet (springs/lattice_correction.h)", Rows::any, true},
    });
    return solid ? space : plane;
}

void write_energy_model(Hdf5Writer& file, const EnergyModel& energy_model) {
    TableWriter out(file, energy_model_table(energy_model.patch.hardens()));
    out.write_texts("/law/terms", energy_model.terms);
    out.write("/law/coefficients", energy_model.coefficients);
    out.write("/law/constants", energy_model.constants);
    out.write("/law/patch_log", NodeField(energy_model.patch.log_N_m));
    file.attribute("/law", "incompressible", energy_model.incompressible ? 1.0 : 0.0);
    if (!energy_model.curve.hookean()) {
        file.attribute("/law", "c2_share", energy_model.curve.q());
        file.attribute("/law", "straight_below", energy_model.curve.shorter().stretch);
        file.attribute("/law", "straight_above", energy_model.curve.longer().stretch);
    }
    if (energy_model.disc.ground.rows() > 0) out.write("/law/ground", energy_model.disc.ground);
    if (std::isfinite(energy_model.disc.curved_range[0])) out.write("/law/curved_range", Eigen::VectorXd(energy_model.disc.curved_range));
    if (energy_model.disc.correction.value.rows() > 0) out.write("/law/lattice_correction", energy_model.disc.correction.value);
    if (!energy_model.sizes.empty()) {
        out.write("/law/radii", energy_model.sizes.radii_m);
        if (!energy_model.sizes.correction.empty()) {
            const NodeField& own = energy_model.sizes.correction.front().value;
            NodeField all(own.rows() * static_cast<Eigen::Index>(energy_model.sizes.correction.size()), own.cols());
            for (std::size_t k = 0; k < energy_model.sizes.correction.size(); ++k) all.middleRows(static_cast<Eigen::Index>(k) * own.rows(), own.rows()) = energy_model.sizes.correction[k].value;
            out.write("/law/radius_corrections", all);
        }
    }
    if (energy_model.patch.hardens()) file.attribute("/law", "disc_radius_m", energy_model.disc_radius_m);
    if (energy_model.contact_log_scale.size() > 0) out.write("/law/contact_log_scale", energy_model.contact_log_scale);
    if (energy_model.relaxation.empty()) return;
    out.write("/law/relaxation_time", energy_model.relaxation.tau_s);
    out.write("/law/share", energy_model.relaxation.share);
    out.write("/law/contact_share", energy_model.relaxation.contact_share);
}

namespace {

/// Data for other disc radii. energy_model: the energy model with its own disc and correction already read.
DiscSizes read_sizes(TableReader& in, const SpringMesh& mesh, const EnergyModel& energy_model) {
    DiscSizes sizes;
    sizes.radii_m = in.vector("/law/radii");
    sizes.spacing_m = mesh.embedding.spacing_m;
    const Eigen::Index K = sizes.radii_m.size(), T = mesh.facets.rows(), V = energy_model.disc.correction.value.cols();
    if (!(sizes.radii_m.array() == energy_model.disc_radius_m).any()) in.refuse("/law/radii", "do not include attribute 'disc_radius_m'");
    if (in.has("/law/radius_corrections") != (V > 0)) in.refuse("/law/radius_corrections", "and lattice_correction belong together");
    if (V == 0) return sizes;
    const NodeField all = in.field("/law/radius_corrections");
    if (all.rows() != K * T || all.cols() != V) in.refuse("/law/radius_corrections", fmt::format("are {} x {}, must be {} x {}", all.rows(), all.cols(), K * T, V));
    for (Eigen::Index k = 0; k < K; ++k) sizes.correction.push_back({all.middleRows(k * T, T)});
    return sizes;
}

}  // namespace

EnergyModel read_energy_model(const Hdf5Reader& file, const SpringMesh& mesh) {
    TableReader in(file, energy_model_table(mesh.is_solid()), {{"N", static_cast<std::size_t>(mesh.node_count())}});
    EnergyModel energy_model;
    energy_model.terms = in.texts("/law/terms");
    energy_model.coefficients = in.vector("/law/coefficients");
    energy_model.constants = in.vector("/law/constants");
    const NodeField patch = in.field("/law/patch_log");
    const Eigen::Index rows = mesh.is_solid() ? ContactParameters::disc_rows : ContactParameters::hardening_row;
    if (patch.rows() != rows) in.refuse("/law/patch_log", fmt::format("has {} rows, must have {}", patch.rows(), rows));
    if (patch.cols() != ContactParameters::factors) in.refuse("/law/patch_log", fmt::format("has {} columns, must have {}", patch.cols(), ContactParameters::factors));
    energy_model.patch.log_N_m = patch;
    energy_model.patch.curve = contact_curve(energy_model.terms);
    if (mesh.is_solid()) {
        if (in.has("/law/ground")) energy_model.disc.ground = in.field("/law/ground");
        if (in.has("/law/curved_range")) {
            const Eigen::VectorXd range = in.vector("/law/curved_range");
            if (range.size() != 2) in.refuse("/law/curved_range", fmt::format("has {} values, must have 2", range.size()));
            if (!(range[0] <= range[1])) in.refuse("/law/curved_range", "must be [smallest, largest]");
            energy_model.disc.curved_range = range;
        }
        if (in.has("/law/lattice_correction")) {
            NodeField& value = energy_model.disc.correction.value = in.field("/law/lattice_correction");
            if (value.rows() != mesh.facets.rows()) in.refuse("/law/lattice_correction", fmt::format("has {} rows, must have one for each of {} facets", value.rows(), mesh.facets.rows()));
            if (FacetTable::parts_of(value.cols()) == 0) in.refuse("/law/lattice_correction", fmt::format("has {} columns, must have (p + 1)(p + 2) / 2", value.cols()));
        }
        energy_model.disc_radius_m = file.number_attribute("/law", "disc_radius_m");
        if (!(energy_model.disc_radius_m > 0 && energy_model.disc_radius_m < 1e3))
            in.refuse("/law", fmt::format("attribute 'disc_radius_m' is {}, must be a number > 0", energy_model.disc_radius_m));
        if (in.has("/law/radii")) {
            if (file.number_attribute("/", "format_version") < rows_format_version) in.refuse("/law/radii", "are of a format version below 11, whose contacts do not depend on the lattice's spacing; train the model again");
            energy_model.sizes = read_sizes(in, mesh, energy_model);
        }
    }
    const double incompressible = file.number_attribute("/law", "incompressible");
    if (incompressible != 0 && incompressible != 1)
        in.refuse("/law", fmt::format("attribute 'incompressible' is {}, must be 0 or 1", incompressible));
    energy_model.incompressible = incompressible == 1;
    if (file.has_attribute("/law", "c2_share")) {
        const auto within = [&](const char* name, double least, double most) {
            const double value = file.number_attribute("/law", name);
            if (!(value >= least && value <= most)) in.refuse("/law", fmt::format("attribute '{}' is {}, must be a number in {} .. {}", name, value, least, most));
            return value;
        };
        const double share = within("c2_share", 0, 1), below = within("straight_below", 0.1, 0.99), above = within("straight_above", 1, 10);
        try {
            energy_model.curve = SpringCurve::mooney_rivlin(share, mesh.dimension(), below, above);
        } catch (const MismatchError& e) {
            in.refuse("/law", e.what());
        }
    }
    if (in.has("/law/contact_log_scale")) energy_model.contact_log_scale = in.vector("/law/contact_log_scale");
    if (in.has("/law/relaxation_time")) {
        energy_model.relaxation = {in.vector("/law/relaxation_time"), in.field("/law/share"), in.vector("/law/contact_share")};
        if (energy_model.relaxation.branches() > ToolMemory::most_branches)
            in.refuse("/law/relaxation_time", fmt::format("are {}, more than {}", energy_model.relaxation.branches(), ToolMemory::most_branches));
        if (!(energy_model.relaxation.share.rowwise().sum().maxCoeff() < 1)) in.refuse("/law/share", "sum to 1 or more in a row");
        if (!(energy_model.relaxation.contact_share.sum() < 1)) in.refuse("/law/contact_share", "sum to 1 or more");
    }
    try {
        const int wanted = TissueEnergy(mesh, energy_model.incompressible, energy_model.curve).constant_count();
        if (energy_model.constants.size() != wanted)
            in.refuse("/law/constants", fmt::format("are {}, must be {} for this mesh", energy_model.constants.size(), wanted));
    } catch (const MismatchError& e) {
        in.refuse("/mesh", e.what());
    }
    return energy_model;
}

}  // namespace tissue
