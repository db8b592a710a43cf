#include "study/study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "error.h"
#include "io/one_line.h"
#include "mesh/fixed_region.h"
#include "mesh/topology.h"
#include "springs/spring_law.h"
#include "study/based_on.h"
#include "study/bed.h"
#include "study/histories.h"
#include "study/kinds.h"
#include "study/read_parts.h"
#include "study/solid_study.h"
#include "study/toml_reader.h"
#include "study/viscosity.h"
#include "surface_file/surface_file.h"
#include "surface_file/vtk_file.h"

namespace tissue {
namespace {

constexpr double most_nodes = 100'000;  // of a lattice, so that its matrices fit into memory

const Range area_caps{1.0 / 3, 1000, true};

/// Keys of [training] that only spring sets, or only an energy model, have; `ridge` is in both lists.
const std::vector<const char*> sets_keys = {"optimizer",   "also",            "objective", "ridge",    "iterations",
                                            "max_seconds", "target_rel_loss", "k_min_E2",  "k_max_E2", "weight_near",
                                            "weight_far"};
const std::vector<const char*> energy_model_keys = {"force_scale", "shape_scale", "starts", "ridge"};

std::vector<std::string> topologies_of(const Study::Geometry& geometry) {
    std::vector<std::string> names;
    for (const Topology& kind : topologies().kinds()) {
        const bool fits = geometry.is_block() || !kind.needs_lattice();
        if (kind.dimension == (geometry.is_solid() ? 3 : 2) && fits) names.push_back(kind.name);
    }
    return names;
}

bool ends_with(const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

Study::Geometry read_geometry(TomlReader in) {
    Study::Geometry g{};
    g.unit_m = 1;
    if (in.has("bed_Pa_m") && !in.has("solid")) in.refuse("bed_Pa_m", "needs a shape with geometry.solid; in other tissue the fixed parts do not move");
    if (in.has("length_m")) {
        if (in.has("solid")) in.refuse("solid", "is only for a shape; a block with length_m is already a solid");
        for (const char* key : {"thickness_m", "shape", "unit_m", "fixed"})
            if (in.has(key)) in.refuse(key, "is only for the plane; a block with length_m is a solid");
        g.length_m = in.number("length_m", positive);
        g.width_m = in.number("width_m", positive);
        g.height_m = in.number("height_m", positive);
        g.thickness_m = 1;
        in.refuse_the_rest();
        return g;
    }
    if (in.has("solid")) {
        if (!in.flag("solid")) in.refuse("solid", "must be true; leave it out in the plane");
        if (in.has("thickness_m")) in.refuse("thickness_m", "is only for the plane; a solid has none");
        if (!in.has("shape")) in.refuse("solid", "needs geometry.shape; a block is a solid by its length_m");
        g.solid = true;
    }
    g.thickness_m = g.solid ? 1 : in.number("thickness_m", positive);
    const std::string shape = in.has("shape") ? in.text("shape") : "block";
    if (shape == "block" && !g.solid) {
        g.width_m = in.number("width_m", positive);
        g.height_m = in.number("height_m", positive);
    } else {
        if (const std::string why = vtk_refusal(in.beside("shape", shape)); !why.empty()) in.refuse("shape", why);
        if (g.solid && !ends_with(shape, ".geo") && !ends_with(shape, ".msh") && !is_surface_file(shape))
            in.refuse("shape", fmt::format("'{}' must be a file that ends in .geo, .msh, {}", shape, surface_endings));
        if (!g.solid && !ends_with(shape, ".geo") && !ends_with(shape, ".msh"))
            in.refuse("shape", "'" + shape + "' must be block, or a file that ends in .geo or .msh");
        g.shape = file_beside(in, "shape", shape);
        const bool trusted = in.has("trust_geo") && in.flag("trust_geo");
        if (ends_with(shape, ".geo") && !trusted)
            in.refuse("shape", g.shape + " is a program, which gmsh runs and which may run any command; give geometry.trust_geo = true if you trust it");
        g.unit_m = in.optional_number("unit_m", positive).value_or(1);
        g.fixed = in.texts("fixed");
        if (g.fixed.empty()) in.refuse("fixed", g.solid ? "must name at least one physical surface of the shape, or a region: \"below z = 0.01\"" : "must name at least one physical curve of the shape");
        for (std::string& name : g.fixed) {
            if (!g.solid) continue;
            try {
                if (auto other = FixedRegion::within(name)) {
                    other->file = in.beside("fixed", other->file);
                    if (const std::string why = vtk_refusal(other->file); !why.empty()) in.refuse("fixed", why);
                    std::error_code none;
                    if (!std::filesystem::is_regular_file(other->file, none)) in.refuse("fixed", "'" + name + "': there is no file " + other->file);
                    name = other->word();
                } else if (const auto region = FixedRegion::of(name)) {
                    name = region->word();
                }
            } catch (const MismatchError& e) {
                in.refuse("fixed", e.what());
            }
            if (name.find(',') != std::string::npos) in.refuse("fixed", "'" + name + "' has a comma, which separates names");
        }
        if (in.has("bed_Pa_m")) {
            const bool each = in.is_list("bed_Pa_m");
            g.bed_Pa_m = each ? in.numbers("bed_Pa_m", not_negative) : std::vector<double>(g.fixed.size(), in.number("bed_Pa_m", not_negative));
            if (g.bed_Pa_m.size() != g.fixed.size()) in.refuse("bed_Pa_m", fmt::format("has {} numbers for the {} names of 'fixed'", g.bed_Pa_m.size(), g.fixed.size()));
            for (double k : g.bed_Pa_m)
                if (k != 0 && !(k >= bed_least_Pa_m && k <= bed_most_Pa_m))
                    in.refuse("bed_Pa_m", fmt::format("must be 0, which is rigid, or {:g} to {:g} Pa/m (fat of E = 2000 Pa, 0.01 m thick: 200000), not {:g}", bed_least_Pa_m, bed_most_Pa_m, k));
            if (g.beds_Pa_m().empty()) g.bed_Pa_m.clear();
            if (g.beds_Pa_m().size() > most_beds) in.refuse("bed_Pa_m", fmt::format("has {} different numbers, at most {} are possible", g.beds_Pa_m().size(), most_beds));
        }
    }
    in.refuse_the_rest();
    return g;
}

/// Adds the keys of fem/materials/NAME.toml that the study's [material] does not have.
void apply_preset(toml::table& table, const std::string& file) {
    toml::table* material = table["material"].as_table();
    if (!material || !material->get("preset")) return;
    TomlReader in(*material, file, "material");
    const std::string name = in.text("preset");
    if (!is_plain_name(name)) in.refuse("preset", "must be the name of a file in materials/, without its ending");
    for (const char* key : {"law", "C1_Pa", "C2_Pa", "mu_Pa", "alpha"})
        if (in.has(key)) in.refuse(key, "is not possible with material.preset, which gives it");
    const std::string preset_file = in.beside("preset", "../materials/" + name + ".toml");
    std::error_code error;
    if (!std::filesystem::is_regular_file(preset_file, error)) {
        std::vector<std::string> known;
        for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(preset_file).parent_path(), error))
            known.push_back(entry.path().stem().string());
        std::sort(known.begin(), known.end());
        in.refuse("preset", fmt::format("'{}' is not a material; there are: {}", name, fmt::join(known, ", ")));
    }
    material->erase("preset");
    underlay(*material, parse_study_file(preset_file));
}

/// measured: the study has measured forces and no finite elements.
Study::Material read_material(TomlReader in, const Study::Geometry& geometry, bool measured) {
    Study::Material m;
    m.law = in.choice("law", {"mooney-rivlin", "neo-Hookean", "ogden"});
    static_cast<Study::MaterialParameters&>(m) = read_material_parameters(in, m.law);
    m.density_kg_m3 = in.number("density_kg_m3", positive);
    if (geometry.is_solid()) {
        if (in.has("formulation")) in.refuse("formulation", fmt::format("is only for the plane; a solid {} is incompressible", geometry.is_block() ? "block" : "shape"));
        if (in.has("regions") && geometry.is_block()) in.refuse("regions", "needs a geometry.shape whose file names them; a solid block has [nodule]");
        if (in.has("regions") && is_surface_file(geometry.shape)) in.refuse("regions", "are physical volumes, and this file has only a surface");
        m.formulation = "incompressible";
    } else {
        m.formulation = in.choice("formulation", {"plane-stress", "plane-strain"});
    }
    read_viscosity(in, m, !measured);
    if (in.has("regions")) {
        if (geometry.is_block()) in.refuse("regions", "needs a geometry.shape whose file names them");
        TomlReader regions = in.table("regions");
        for (const std::string& name : regions.keys()) {
            TomlReader region = regions.table(name);
            m.regions.push_back({read_material_parameters(region, m.law, m.alpha.size()), name});
            read_own_viscosity(region, m, m.regions.back());
            region.refuse_the_rest();
        }
    }
    in.refuse_the_rest();
    return m;
}

Study::Loads read_loads(TomlReader in, const Study::Geometry& geometry, const Study::Indenter& indenter) {
    constexpr double tiny_m = 1e-9;
    const double least_m = indenter.clearance_m();
    Study::Loads loads = read_magnitudes(in, geometry);
    if (in.has("sweep")) {
        in.refuse_unless_empty("paths", "must be empty with a sweep");
        TomlReader sweep = in.table("sweep");
        const bool listed = sweep.has("arcs_m");
        if (listed && sweep.has("spacing_m")) sweep.refuse("arcs_m", "is not possible with spacing_m: contacts are listed or spaced");
        const double spacing_m = listed ? 0 : sweep.number("spacing_m", positive);
        loads.sweep = Study::Loads::Sweep{spacing_m, sweep.number("clearance_m", positive), sweep.numbers("angles_deg", {-75, 75})};
        if (loads.sweep->clearance_m < least_m - tiny_m)
            sweep.refuse("clearance_m", indenter.kind == "patch"
                                            ? fmt::format("a patch of half width {:g} mm needs {:g} mm to the fixed edge", 1e3 * indenter.half_width_m, 1e3 * least_m)
                                            : fmt::format("a point needs {:g} mm to the fixed edge", 1e3 * least_m));
        if (listed) loads.sweep->arcs_m = sweep.numbers("arcs_m", positive);
        for (std::size_t i = 1; i < loads.sweep->arcs_m.size(); ++i)
            if (!(loads.sweep->arcs_m[i] > loads.sweep->arcs_m[i - 1])) sweep.refuse("arcs_m", "must be ascending");
        for (std::size_t i = 1; i < loads.sweep->angles_deg.size(); ++i)
            if (!(loads.sweep->angles_deg[i] > loads.sweep->angles_deg[i - 1]))
                sweep.refuse("angles_deg", "must be ascending");
        for (std::size_t i = 0, n = loads.sweep->angles_deg.size(); geometry.is_block() && i < n; ++i)
            if (loads.sweep->angles_deg[i] != -loads.sweep->angles_deg[n - 1 - i])
                sweep.refuse("angles_deg", "must be symmetric about 0, because the block is symmetric");
        sweep.refuse_the_rest();
        in.refuse_the_rest();
        return loads;
    }
    if (in.tables("paths").empty()) in.refuse("paths", "must not be empty without a sweep");
    std::set<std::string> names;
    for (TomlReader& path : in.tables("paths")) {
        StudyPath p;
        p.name = path.text("name");
        if (!is_plain_name(p.name)) path.refuse("name", "must have only lower-case letters, digits and '-'");
        if (!names.insert(p.name).second) path.refuse("name", "'" + p.name + "' is present twice");
        const std::vector<double> contact = path.numbers("contact_m", 2), push = path.numbers("push", 2);
        p.contact_m = Eigen::Vector2d(contact[0], contact[1]);
        p.direction = Eigen::Vector2d(push[0], push[1]);
        if (!(p.direction.norm() > 0)) path.refuse("push", "must not be zero");
        p.direction.normalize();
        const double x = contact[0], y = contact[1], w = geometry.width_m, h = geometry.height_m;
        const bool on_side = (x == 0 || x == w) && y > 0 && y <= h, on_top = y == h && x >= 0 && x <= w;
        if (geometry.is_block() && !on_side && !on_top)
            path.refuse("contact_m", fmt::format("({}, {}) m is not on the free surface of the {} x {} m block", x, y,
                                                 w, h));
        // next to the fixed edge a patch stretches the tissue instead of indenting it; FE there is of no use for
        // training
        if (geometry.is_block() && indenter.kind == "patch" && on_side && !on_top && y < least_m - tiny_m)
            path.refuse("contact_m", fmt::format("is {:g} mm from the fixed edge; a patch of half width {:g} mm needs {:g} mm", 1e3 * y, 1e3 * indenter.half_width_m,
                                                 1e3 * least_m));
        path.refuse_the_rest();
        loads.paths.push_back(p);
    }
    in.refuse_the_rest();
    return loads;
}

Study::Springs read_springs(TomlReader in, const Study::Geometry& geometry, bool measured) {
    Study::Springs s;
    s.topology = in.choice("topology", topologies_of(geometry));
    if (s.topology == "embedded") s.spacing_m = in.number("spacing_m", positive);
    s.stiffness = in.has("stiffness") ? in.choice("stiffness", {"sets", "law"}) : "sets";
    if (geometry.is_solid() && !s.is_energy_model()) in.refuse("stiffness", fmt::format("must be \"law\" on a solid {}: spring sets are for the plane", geometry.is_block() ? "block" : "shape"));
    if (measured && !s.is_energy_model())
        in.refuse("stiffness", "must be \"law\" with [data]: spring sets need the displacement of nodes inside, which is not measured");
    if (!s.is_energy_model()) {
        for (const char* key : {"terms", "area_cap_E2", "curve"})
            if (in.has(key)) in.refuse(key, "needs stiffness = \"law\"");
        s.law = in.choice("law", spring_laws().names());
        in.refuse_the_rest();
        return s;
    }
    if (in.has("law")) in.refuse("law", "needs stiffness = \"sets\": springs of an energy model rotate with the tissue");
    if (s.topology == "grid4") in.refuse("topology", "'grid4' is not possible with an energy model: without diagonals it has zero-energy modes");
    s.law = "geometric";
    s.terms = in.texts("terms");
    if (s.terms.empty()) in.refuse("terms", "must name at least one term (lib/springs/energy_model_terms.h)");
    std::set<std::string> known;
    for (const std::string& term : s.terms)
        if (!known.insert(term).second) in.refuse("terms", "'" + term + "' is present twice");
    s.area_cap_E2 = in.optional_number("area_cap_E2", area_caps).value_or(12);
    if (in.has("curve") && !geometry.is_solid()) in.refuse("curve", "needs tissue in space: in the plane springs are Hooke's");
    s.hookean = in.has("curve") ? in.choice("curve", {"material", "hooke"}) == "hooke" : !geometry.is_solid();
    in.refuse_the_rest();
    return s;
}

/// [training] of an energy model. The defaults are those of EnergyModelTrainingOptions. force_scale is about the discretisation
/// error of FE, shape_scale about the smallest visible error of displacement.
Study::Training read_energy_model_training(TomlReader in, bool measured) {
    for (const char* key : sets_keys)
        if (in.has(key) && std::string(key) != "ridge") in.refuse(key, "needs springs.stiffness = \"sets\"");
    if (measured && in.has("shape_scale"))
        in.refuse("shape_scale", "needs finite elements: displacements inside are not measured");
    Study::Training t{};
    t.force_scale = in.optional_number("force_scale", positive).value_or(0.01);
    t.shape_scale = in.optional_number("shape_scale", positive).value_or(0.03);
    t.ridge = in.optional_number("ridge", not_negative).value_or(0.1);
    t.starts = static_cast<int>(in.optional_integer("starts", 1, 1000).value_or(1));
    t.seed = static_cast<unsigned long>(in.optional_integer("seed", 0, std::numeric_limits<int>::max()).value_or(1));
    in.refuse_the_rest();
    return t;
}

Study::Training read_training(TomlReader in) {
    for (const char* key : energy_model_keys)
        if (in.has(key) && std::string(key) != "ridge") in.refuse(key, "needs springs.stiffness = \"law\"");
    Study::Training t{};
    t.optimizer = in.text("optimizer");
    t.also = in.texts("also");
    const std::vector<std::string> optimizers = optimizer_names();
    const auto is_optimizer = [&](const std::string& name) {
        return std::find(optimizers.begin(), optimizers.end(), name) != optimizers.end();
    };
    const std::string allowed = fmt::format("is not an optimiser; allowed: {}", fmt::join(optimizers, ", "));
    if (!is_optimizer(t.optimizer)) in.refuse("optimizer", "'" + t.optimizer + "' " + allowed);
    for (const std::string& other : t.also)
        if (!is_optimizer(other)) in.refuse("also", "'" + other + "' " + allowed);
    t.objective = in.has("objective") ? in.choice("objective", objective_names()) : objective_names().front();
    t.ridge = in.optional_number("ridge", not_negative).value_or(0);
    t.seed = static_cast<unsigned long>(in.integer("seed", 0, std::numeric_limits<int>::max()));
    t.iterations = static_cast<int>(in.integer("iterations", 1, 100'000'000));
    t.max_seconds = in.optional_number("max_seconds", positive);
    t.target_rel_loss = in.optional_number("target_rel_loss", positive);
    t.k_min_E2 = in.number("k_min_E2", positive);
    t.k_max_E2 = in.number("k_max_E2", positive);
    if (!(t.k_min_E2 <= 0.5)) in.refuse("k_min_E2", "must be at most 0.5, or the heuristic starts outside the box");
    if (!(t.k_max_E2 >= 1)) in.refuse("k_max_E2", "must be at least 1, or the heuristic starts outside the box");
    const auto weights = [&](const char* key, double (&out)[2]) {
        const std::vector<double> range = in.numbers(key, 2, {0, 1});
        if (range[0] > range[1]) in.refuse(key, "must be [smallest, largest]");
        std::copy(range.begin(), range.end(), out);
    };
    weights("weight_near", t.weight_near);
    weights("weight_far", t.weight_far);
    in.refuse_the_rest();
    return t;
}

void read_draws(TomlReader in, Study& study) {
    for (const char* role : {"validation", "held_out", "held_out_full"}) {
        if (!in.has(role)) continue;
        TomlReader draw = in.table(role);
        Study::Draws d;
        d.role = role;
        read_seed_and_count(draw, d);
        read_depth(draw, study, d);
        d.max_angle_deg = draw.number("max_angle_deg", {0, 75});
        add_draws(draw, d, study);
    }
    in.refuse_the_rest();
}

/// [mesh], [indenter], [solver] and [loads] of a study in the plane.
void read_fe(TomlReader& in, Study& study) {
    TomlReader mesh = in.table("mesh");
    study.refine = static_cast<int>(mesh.integer("refine", 1, 100));
    const bool block = study.geometry.is_block();
    if (block && study.cells[0] * study.refine % 2 != 0)
        mesh.refuse("refine", "times lattice.cells[0] must be even, so that the two halves are symmetric");
    study.check_refine = static_cast<int>(mesh.optional_integer("check_refine", 0, 100).value_or(0));
    study.check_fraction = mesh.optional_number("check_fraction", {0, 1}).value_or(1);
    if (study.check_refine != 0 && study.check_refine <= study.refine)
        mesh.refuse("check_refine", "must be 0 or larger than refine");
    if (block && study.cells[0] * study.check_refine % 2 != 0)
        mesh.refuse("check_refine", "times lattice.cells[0] must be even, so that the two halves are symmetric");
    mesh.refuse_the_rest();

    TomlReader indenter = in.table("indenter");
    study.indenter.kind = indenter.choice("kind", {"point", "patch"});
    const bool patch = study.indenter.kind == "patch";
    study.indenter.half_width_m = patch ? indenter.number("half_width_m", positive) : 0;
    indenter.refuse_the_rest();
    // FE nodes near the ends of a patch are moved onto them; with longer elements there would be no node to move
    if (patch && study.spring_size_m / study.refine > 1.001 * study.indenter.half_width_m)
        mesh.refuse("refine", "must make finite elements, lattice.size_m / refine, at most as long as indenter.half_width_m");

    study.solver = read_solver(in.table("solver"));
    study.loads = read_loads(in.table("loads"), study.geometry, study.indenter);
}

/// [data]: measured contacts in place of finite elements.
void read_data(TomlReader& in, Study& study) {
    for (const char* key : {"mesh", "indenter", "solver", "loads", "draws", "variants", "histories"})
        if (in.has(key)) in.refuse(key, "needs finite elements; a study with [data] has none");
    TomlReader data = in.table("data");
    Study::Data d;
    d.file = (std::filesystem::path(study.file).parent_path() / data.text("file")).lexically_normal().string();
    if (data.has("histories")) d.histories = (std::filesystem::path(study.file).parent_path() / data.text("histories")).lexically_normal().string();
    d.seed = static_cast<unsigned long>(data.integer("seed", 0, std::numeric_limits<int>::max()));
    d.validation_part = data.number("validation_part", {0, 0.5});
    d.held_out_part = data.number("held_out_part", {0, 0.5, true});
    d.surface_tolerance_m = data.optional_number("surface_tolerance_m", not_negative).value_or(0.0005);
    d.stated_force_noise = data.optional_number("stated_force_noise", not_negative);
    if (study.material.fits_shares && d.histories.empty()) data.refuse("histories", "is missing: material.viscosity needs it to fit the relative moduli");
    if (!d.histories.empty() && !study.material.relaxes())
        data.refuse("histories", "needs tissue that relaxes; give material.viscosity = \"measured\", and moduli");
    data.refuse_the_rest();
    study.data = d;
}

Study::Variant read_variant(TomlReader in, const Study& study) {
    Study::Variant v = study.whole();
    v.name = in.text("name");
    const auto count = static_cast<long>(study.springs.terms.size());
    v.terms.assign(study.springs.terms.begin(), study.springs.terms.begin() + in.optional_integer("first_terms", 1, count).value_or(count));
    v.area_cap_E2 = in.optional_number("area_cap_E2", area_caps).value_or(v.area_cap_E2);
    v.shape_scale = in.optional_number("shape_scale", positive).value_or(v.shape_scale);
    const auto some_of = [&in](const char* key, const std::vector<double>& all) {
        if (!in.has(key)) return all;
        const std::vector<double> kept = in.numbers(key);
        for (double k : kept)
            if (std::find(all.begin(), all.end(), k) == all.end()) in.refuse(key, "every entry must be one of the study's");
        return kept;
    };
    if (study.geometry.is_solid()) {
        v.first_paths = static_cast<int>(in.optional_integer("first_paths", 1, static_cast<long>(study.loads.path_count())).value_or(0));
    } else {
        v.arcs_m = some_of("arcs_m", v.arcs_m);
        v.angles_deg = some_of("angles_deg", v.angles_deg);
    }
    v.magnitudes_m = some_of("magnitudes_m", v.magnitudes_m);
    in.refuse_the_rest();
    return v;
}

}  // namespace

double Study::MaterialParameters::youngs_modulus_Pa() const {
    if (alpha.empty()) return 6 * (C1_Pa + C2_Pa);
    double twice_mu = 0;
    for (std::size_t k = 0; k < alpha.size(); ++k) twice_mu += mu_Pa[k] * alpha[k];
    return 3 * twice_mu / 2;
}

double Study::MaterialParameters::second_share() const {
    if (alpha.empty()) return C2_Pa / (C1_Pa + C2_Pa);
    double sum = 0, curved = 0;
    for (std::size_t k = 0; k < alpha.size(); ++k) {
        sum += mu_Pa[k] * alpha[k];
        curved += mu_Pa[k] * alpha[k] * (alpha[k] / 4 - 1.5);
    }
    return std::clamp(-1 - curved / sum, 0.0, 1.0);
}

std::vector<std::string> Study::Material::region_names() const {
    std::vector<std::string> names;
    for (const Region& r : regions) names.push_back(r.name);
    return names;
}

double Study::Indenter::clearance_m(double disc_radius_m) const {
    constexpr double disc_margin_m = 0.005, most_m = 0.015;
    if (kind == "disc") return disc_radius_m + disc_margin_m;
    return kind == "patch" ? std::max(half_width_m, std::min(3 * half_width_m, most_m)) : most_m;
}

Study::Variant Study::whole() const {
    const std::vector<double> none;
    return {name, springs.terms, springs.area_cap_E2, training.shape_scale, loads.sweep ? loads.sweep->arcs_m : none,
            loads.sweep ? loads.sweep->angles_deg : none, loads.magnitudes_m};
}

Lattice Study::lattice() const {
    if (geometry.is_solid()) return {cells, {geometry.width_m, geometry.length_m, geometry.height_m}};
    return {cells, {geometry.width_m, geometry.height_m}};
}

std::size_t Study::Loads::path_count() const {
    std::size_t count = paths.size() + (spread ? static_cast<std::size_t>(spread->count * spread->pushes_each) : 0);
    for (const Contact& contact : contacts) count += contact.pushes_deg.size();
    return count;
}

int Study::Loads::records() const {
    return static_cast<int>(std::lround(depth_m() / record_step_m));
}

Study read_study(const std::string& file) {
    toml::table table = parse_with_base(file);
    apply_preset(table, file);
    TomlReader in(table, file, "");
    Study study{};
    study.file = file;
    study.name = std::filesystem::path(file).stem().string();

    study.geometry = read_geometry(in.table("geometry"));
    study.material = read_material(in.table("material"), study.geometry, in.has("data"));
    const bool block = study.geometry.is_block(), solid = study.geometry.is_solid();
    if (block) {
        TomlReader lattice = in.table("lattice");
        const std::vector<double> cells = lattice.numbers("cells", solid ? 3 : 2, {1, 2000});
        study.cells.assign(cells.begin(), cells.end());
        if (!std::equal(cells.begin(), cells.end(), study.cells.begin())) lattice.refuse("cells", "must be whole numbers");
        double nodes = 1;
        for (const double n : cells) nodes *= n + 1;
        if (nodes > most_nodes) lattice.refuse("cells", fmt::format("make {:.0f} nodes; at most {:.0f} are allowed", nodes, most_nodes));
        lattice.refuse_the_rest();
    } else if (!ends_with(study.geometry.shape, ".msh")) {
        TomlReader lattice = in.table("lattice");
        study.spring_size_m = lattice.number("size_m", positive);
        lattice.refuse_the_rest();
    } else if (in.has("lattice")) {
        in.refuse("lattice", solid ? "is only for the block, or a shape that is a .geo or a surface; a .msh already has tetrahedra"
                                   : "is only for the block, or a shape that is a .geo; a .msh already has triangles");
    }

    if (in.has("data") && !block) in.refuse("data", "is possible only on the block; a shape needs finite elements");
    if (in.has("data") && solid) in.refuse("data", "is possible only in the plane; a solid block needs finite elements");
    if (in.has("nodule") && !solid) in.refuse("nodule", "needs a solid, one with geometry.length_m or geometry.solid");
    if (in.has("nodule") && !study.material.regions.empty()) in.refuse("nodule", "is not possible with material.regions");
    if (in.has("map") && (!solid || !block)) in.refuse("map", "needs a solid block, one with geometry.length_m");
    if (in.has("data"))
        read_data(in, study);
    else if (solid)
        read_solid_fe(in, study);
    else
        read_fe(in, study);

    study.springs = read_springs(in.table("springs"), study.geometry, study.data.has_value());
    const bool is_energy_model = study.springs.is_energy_model();
    if (!is_energy_model && study.material.relaxes()) in.table("material").refuse("viscosity", "needs springs.stiffness = \"law\": spring sets do not relax");
    const toml::table nothing;  // an energy model has a default for every key of [training]
    if (is_energy_model) {
        const TomlReader training = in.has("training") ? in.table("training") : TomlReader(nothing, file, "training");
        study.training = read_energy_model_training(training, study.data.has_value());
    } else
        study.training = read_training(in.table("training"));
    if (in.has("draws")) {
        if (!solid && !study.loads.sweep) in.refuse("draws", "needs a study with loads.sweep");
        if (solid) read_solid_draws(in.table("draws"), study);
        else read_draws(in.table("draws"), study);
    }
    if (in.has("histories")) read_histories(in, study);
    if (in.has("variants")) {
        if (!is_energy_model) in.refuse("variants", "need an energy model; this study has spring sets");
        if (!solid && !study.loads.sweep) in.refuse("variants", "needs a study with loads.sweep");
        for (const TomlReader& variant : in.tables("variants")) study.variants.push_back(read_variant(variant, study));
    }
    in.refuse_the_rest();
    return study;
}

std::vector<double> Study::Geometry::beds_Pa_m() const {
    std::vector<double> all;
    for (double k : bed_Pa_m)
        if (k > 0 && std::find(all.begin(), all.end(), k) == all.end()) all.push_back(k);
    return all;
}

std::vector<int> Study::Geometry::beds() const {
    const std::vector<double> all = beds_Pa_m();
    std::vector<int> of;
    for (double k : bed_Pa_m) of.push_back(k > 0 ? static_cast<int>(std::find(all.begin(), all.end(), k) - all.begin()) + 1 : 0);
    return of;
}

}  // namespace tissue
