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

const DatasetTable& law_table(bool solid) {
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

void write_law(Hdf5Writer& file, const EnergyModel& law) {
    TableWriter out(file, law_table(law.patch.hardens()));
    out.write_texts("/law/terms", law.terms);
    out.write("/law/coefficients", law.coefficients);
    out.write("/law/constants", law.constants);
    out.write("/law/patch_log", NodeField(law.patch.log_N_m));
    file.attribute("/law", "incompressible", law.incompressible ? 1.0 : 0.0);
    if (!law.curve.hookean()) {
        file.attribute("/law", "c2_share", law.curve.q());
        file.attribute("/law", "straight_below", law.curve.shorter().stretch);
        file.attribute("/law", "straight_above", law.curve.longer().stretch);
    }
    if (law.disc.ground.rows() > 0) out.write("/law/ground", law.disc.ground);
    if (std::isfinite(law.disc.curved_range[0])) out.write("/law/curved_range", Eigen::VectorXd(law.disc.curved_range));
    if (law.disc.correction.value.rows() > 0) out.write("/law/lattice_correction", law.disc.correction.value);
    if (!law.sizes.empty()) {
        out.write("/law/radii", law.sizes.radii_m);
        if (!law.sizes.correction.empty()) {
            const NodeField& own = law.sizes.correction.front().value;
            NodeField all(own.rows() * static_cast<Eigen::Index>(law.sizes.correction.size()), own.cols());
            for (std::size_t k = 0; k < law.sizes.correction.size(); ++k) all.middleRows(static_cast<Eigen::Index>(k) * own.rows(), own.rows()) = law.sizes.correction[k].value;
            out.write("/law/radius_corrections", all);
        }
    }
    if (law.patch.hardens()) file.attribute("/law", "disc_radius_m", law.disc_radius_m);
    if (law.contact_log_scale.size() > 0) out.write("/law/contact_log_scale", law.contact_log_scale);
    if (law.relaxation.empty()) return;
    out.write("/law/relaxation_time", law.relaxation.tau_s);
    out.write("/law/share", law.relaxation.share);
    out.write("/law/contact_share", law.relaxation.contact_share);
}

namespace {

/// Data for other disc radii. law: the energy model with its own disc and correction already read.
DiscSizes read_sizes(TableReader& in, const SpringMesh& mesh, const EnergyModel& law) {
    DiscSizes sizes;
    sizes.radii_m = in.vector("/law/radii");
    sizes.spacing_m = mesh.embedding.spacing_m;
    const Eigen::Index K = sizes.radii_m.size(), T = mesh.facets.rows(), V = law.disc.correction.value.cols();
    if (!(sizes.radii_m.array() == law.disc_radius_m).any()) in.refuse("/law/radii", "do not include attribute 'disc_radius_m'");
    if (in.has("/law/radius_corrections") != (V > 0)) in.refuse("/law/radius_corrections", "and lattice_correction belong together");
    if (V == 0) return sizes;
    const NodeField all = in.field("/law/radius_corrections");
    if (all.rows() != K * T || all.cols() != V) in.refuse("/law/radius_corrections", fmt::format("are {} x {}, must be {} x {}", all.rows(), all.cols(), K * T, V));
    for (Eigen::Index k = 0; k < K; ++k) sizes.correction.push_back({all.middleRows(k * T, T)});
    return sizes;
}

}  // namespace

EnergyModel read_law(const Hdf5Reader& file, const SpringMesh& mesh) {
    TableReader in(file, law_table(mesh.is_solid()), {{"N", static_cast<std::size_t>(mesh.node_count())}});
    EnergyModel law;
    law.terms = in.texts("/law/terms");
    law.coefficients = in.vector("/law/coefficients");
    law.constants = in.vector("/law/constants");
    const NodeField patch = in.field("/law/patch_log");
    const Eigen::Index rows = mesh.is_solid() ? ContactParameters::disc_rows : ContactParameters::hardening_row;
    if (patch.rows() != rows) in.refuse("/law/patch_log", fmt::format("has {} rows, must have {}", patch.rows(), rows));
    if (patch.cols() != ContactParameters::factors) in.refuse("/law/patch_log", fmt::format("has {} columns, must have {}", patch.cols(), ContactParameters::factors));
    law.patch.log_N_m = patch;
    law.patch.curve = contact_curve(law.terms);
    if (mesh.is_solid()) {
        if (in.has("/law/ground")) law.disc.ground = in.field("/law/ground");
        if (in.has("/law/curved_range")) {
            const Eigen::VectorXd range = in.vector("/law/curved_range");
            if (range.size() != 2) in.refuse("/law/curved_range", fmt::format("has {} values, must have 2", range.size()));
            if (!(range[0] <= range[1])) in.refuse("/law/curved_range", "must be [smallest, largest]");
            law.disc.curved_range = range;
        }
        if (in.has("/law/lattice_correction")) {
            NodeField& value = law.disc.correction.value = in.field("/law/lattice_correction");
            if (value.rows() != mesh.facets.rows()) in.refuse("/law/lattice_correction", fmt::format("has {} rows, must have one for each of {} facets", value.rows(), mesh.facets.rows()));
            if (FacetTable::parts_of(value.cols()) == 0) in.refuse("/law/lattice_correction", fmt::format("has {} columns, must have (p + 1)(p + 2) / 2", value.cols()));
        }
        law.disc_radius_m = file.number_attribute("/law", "disc_radius_m");
        if (!(law.disc_radius_m > 0 && law.disc_radius_m < 1e3))
            in.refuse("/law", fmt::format("attribute 'disc_radius_m' is {}, must be a number > 0", law.disc_radius_m));
        if (in.has("/law/radii")) {
            if (file.number_attribute("/", "format_version") < rows_format_version) in.refuse("/law/radii", "are of a format version below 11, whose contacts do not depend on the lattice's spacing; train the model again");
            law.sizes = read_sizes(in, mesh, law);
        }
    }
    const double incompressible = file.number_attribute("/law", "incompressible");
    if (incompressible != 0 && incompressible != 1)
        in.refuse("/law", fmt::format("attribute 'incompressible' is {}, must be 0 or 1", incompressible));
    law.incompressible = incompressible == 1;
    if (file.has_attribute("/law", "c2_share")) {
        const auto within = [&](const char* name, double least, double most) {
            const double value = file.number_attribute("/law", name);
            if (!(value >= least && value <= most)) in.refuse("/law", fmt::format("attribute '{}' is {}, must be a number in {} .. {}", name, value, least, most));
            return value;
        };
        const double share = within("c2_share", 0, 1), below = within("straight_below", 0.1, 0.99), above = within("straight_above", 1, 10);
        try {
            law.curve = SpringCurve::mooney_rivlin(share, mesh.dimension(), below, above);
        } catch (const MismatchError& e) {
            in.refuse("/law", e.what());
        }
    }
    if (in.has("/law/contact_log_scale")) law.contact_log_scale = in.vector("/law/contact_log_scale");
    if (in.has("/law/relaxation_time")) {
        law.relaxation = {in.vector("/law/relaxation_time"), in.field("/law/share"), in.vector("/law/contact_share")};
        if (law.relaxation.branches() > ToolMemory::most_branches)
            in.refuse("/law/relaxation_time", fmt::format("are {}, more than {}", law.relaxation.branches(), ToolMemory::most_branches));
        if (!(law.relaxation.share.rowwise().sum().maxCoeff() < 1)) in.refuse("/law/share", "sum to 1 or more in a row");
        if (!(law.relaxation.contact_share.sum() < 1)) in.refuse("/law/contact_share", "sum to 1 or more");
    }
    try {
        const int wanted = TissueEnergy(mesh, law.incompressible, law.curve).constant_count();
        if (law.constants.size() != wanted)
            in.refuse("/law/constants", fmt::format("are {}, must be {} for this mesh", law.constants.size(), wanted));
    } catch (const MismatchError& e) {
        in.refuse("/mesh", e.what());
    }
    return law;
}

}  // namespace tissue
