#include "study/study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "error.h"
#include "io/atomic_file.h"
#include "mesh/topology.h"
#include "springs/spring_law.h"
#include "study/kinds.h"
#include "study/one_line.h"
#include "study/solid_push.h"
#include "study/toml_reader.h"

namespace tissue {
namespace {

const Range positive{0, std::numeric_limits<double>::infinity(), true};
const Range not_negative{0};
const Range area_caps{1.0 / 3, 1000, true};
constexpr double tiny_m = 1e-9, tiny_direction = 1e-9;  // what counts as the same place, and as the same push

toml::table parse(const std::string& file) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) throw FileError(one_line(file) + ": there is no such study file");
    return parse_toml(read_file(file), file);
}

void erase_from(toml::table& base, const char* section, std::initializer_list<const char*> keys) {
    toml::node* there = base.get(section);
    if (there && there->is_table())
        for (const char* key : keys) there->as_table()->erase(key);
}

/// Keys of [training] that belong to one kind of stiffness alone.
const std::vector<const char*> sets_keys = {"optimizer",   "also",            "objective", "ridge",    "iterations",
                                            "max_seconds", "target_rel_loss", "k_min_E2",  "k_max_E2", "weight_near",
                                            "weight_far"};
const std::vector<const char*> law_keys = {"force_scale", "shape_scale", "starts", "ridge"};

/// Keys of the base that a choice of this study makes meaningless: the block's, where a shape is given; another law's;
/// those of sets, where stiffness is a law, and the other way; the spacing of contacts that are listed; variants of other contacts.
void erase_replaced(toml::table& base, const toml::table& changes) {
    if (const auto shape = changes["geometry"]["shape"].value<std::string>(); shape && *shape != "block") {
        erase_from(base, "geometry", {"width_m", "height_m"});
        base.erase("lattice");
    }
    if (changes["material"]["preset"])
        erase_from(base, "material", {"law", "C1_Pa", "C2_Pa", "mu_Pa", "alpha", "density_kg_m3", "regions"});
    if (const auto law = changes["material"]["law"].value<std::string>()) {
        erase_from(base, "material", {"preset", "regions"});
        if (*law == "ogden") erase_from(base, "material", {"C1_Pa", "C2_Pa"});
        else erase_from(base, "material", {"mu_Pa", "alpha"});
    }
    if (const auto stiffness = changes["springs"]["stiffness"].value<std::string>()) {
        const bool law = *stiffness == "law";
        if (law)
            erase_from(base, "springs", {"law"});
        else
            erase_from(base, "springs", {"terms", "area_cap_E2"});
        base.erase("variants");
        toml::node* training = base.get("training");
        if (training && training->is_table())
            for (const char* key : law ? sets_keys : law_keys) training->as_table()->erase(key);
    }
    if (changes["loads"]["contacts"]) base.erase("variants");  // which count the base's contacts
    const toml::node_view<const toml::node> sweep = changes["loads"]["sweep"];
    for (const auto& [key, other] : {std::pair("spacing_m", "arcs_m"), std::pair("arcs_m", "spacing_m")})
        if (sweep[key])
            if (toml::table* there = base["loads"]["sweep"].as_table()) there->erase(other);
}

/// The base study's tables with this study's keys put over them; lists are replaced whole. Nodes are moved, not copied:
/// a copy forgets its file and line, which messages name.
void overlay(toml::table& base, toml::table&& changes) {
    for (auto&& [key, node] : changes) {
        toml::node* there = base.get(key);
        if (there && there->is_table() && node.is_table())
            overlay(*there->as_table(), std::move(*node.as_table()));
        else
            node.visit([&, name = std::string(key.str())](auto&& value) { base.insert_or_assign(name, std::move(value)); });
    }
}

toml::table parse_with_base(const std::string& file, int depth = 0) {
    toml::table table = parse(file);
    const toml::node* based_on = table.get("based_on");
    if (!based_on) return table;
    if (!based_on->is_string() || depth > 8)
        throw StudyError(one_line(fmt::format("{}:{}: key 'based_on': must name another study, without a circle", file,
                                              based_on->source().begin.line)));
    const std::filesystem::path base =
        std::filesystem::path(file).parent_path() / (based_on->as_string()->get() + ".toml");
    toml::table merged = parse_with_base(base.string(), depth + 1);
    table.erase("based_on");
    erase_replaced(merged, table);
    overlay(merged, std::move(table));
    return merged;
}

bool is_multiple(double value, double step) {
    return std::abs(value / step - std::round(value / step)) < 1e-9 * value / step;
}

bool is_plain_name(const std::string& name) {
    return !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
}

std::vector<std::string> topologies_of(const Study::Geometry& geometry) {
    std::vector<std::string> names;
    for (const Topology& kind : topologies().kinds())
        if (kind.dimension == (geometry.is_solid() ? 3 : 2) && (geometry.is_block() || !kind.needs_lattice()))
            names.push_back(kind.name);
    return names;
}

bool ends_with(const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// A file that a key names, beside the file in which the key stands.
std::string beside(const toml::node& node, const std::string& study_file, const std::string& name) {
    const std::string& file = node.source().path ? *node.source().path : study_file;
    return (std::filesystem::path(file).parent_path() / name).lexically_normal().string();
}

Study::Geometry read_geometry(TomlReader in, const toml::table& table, const std::string& file) {
    Study::Geometry g{};
    g.unit_m = 1;
    if (in.has("length_m")) {
        for (const char* key : {"thickness_m", "shape", "unit_m", "fixed"})
            if (in.has(key)) in.refuse(key, "belongs to the plane; a block with length_m is a solid");
        g.length_m = in.number("length_m", positive);
        g.width_m = in.number("width_m", positive);
        g.height_m = in.number("height_m", positive);
        g.thickness_m = 1;
        in.refuse_the_rest();
        return g;
    }
    g.thickness_m = in.number("thickness_m", positive);
    const std::string shape = in.has("shape") ? in.text("shape") : "block";
    if (shape == "block") {
        g.width_m = in.number("width_m", positive);
        g.height_m = in.number("height_m", positive);
    } else {
        if (!ends_with(shape, ".geo") && !ends_with(shape, ".msh"))
            in.refuse("shape", "'" + shape + "' must be block, or a file that ends in .geo or .msh");
        g.shape = beside(*table["geometry"]["shape"].node(), file, shape);
        std::error_code error;
        if (!std::filesystem::is_regular_file(g.shape, error)) in.refuse("shape", "there is no file " + g.shape);
        g.unit_m = in.optional_number("unit_m", positive).value_or(1);
        g.fixed = in.texts("fixed");
        if (g.fixed.empty()) in.refuse("fixed", "must name at least one physical curve of the shape");
    }
    in.refuse_the_rest();
    return g;
}

Study::LawParameters read_law_parameters(TomlReader& in, const std::string& law, std::size_t terms = 0) {
    Study::LawParameters p;
    if (law == "ogden") {
        p.mu_Pa = in.numbers("mu_Pa");
        p.alpha = in.numbers("alpha", {-50, 50});
        if (p.mu_Pa.size() != p.alpha.size()) in.refuse("alpha", "must have as many entries as mu_Pa");
        if (terms != 0 && p.alpha.size() != terms) in.refuse("alpha", "must have as many entries as the base material's");
        for (double a : p.alpha)
            if (!(std::abs(a) >= 1e-3)) in.refuse("alpha", "no entry may be 0");
        if (!(p.youngs_modulus_Pa() > 0)) in.refuse("mu_Pa", "the sum of mu_Pa times alpha must be > 0");
        return p;
    }
    p.C1_Pa = in.number("C1_Pa", not_negative);
    p.C2_Pa = law == "neo-Hookean" ? in.optional_number("C2_Pa", not_negative).value_or(0) : in.number("C2_Pa", not_negative);
    if (law == "neo-Hookean" && p.C2_Pa != 0) in.refuse("C2_Pa", "must be 0 for the neo-Hookean law");
    if (!(p.C1_Pa + p.C2_Pa > 0)) in.refuse("C1_Pa", "C1_Pa + C2_Pa must be > 0");
    return p;
}

/// Puts what fem/materials/NAME.toml says under the study's own keys.
void apply_preset(toml::table& table, const std::string& file) {
    toml::table* material = table["material"].as_table();
    if (!material || !material->get("preset")) return;
    TomlReader in(*material, file, "material");
    const std::string name = in.text("preset");
    if (!is_plain_name(name)) in.refuse("preset", "must be the name of a file in materials/, without its ending");
    for (const char* key : {"law", "C1_Pa", "C2_Pa", "mu_Pa", "alpha"})
        if (in.has(key)) in.refuse(key, "cannot stand beside material.preset, which says it");
    const std::string preset_file = beside(*material->get("preset"), file, "../materials/" + name + ".toml");
    std::error_code error;
    if (!std::filesystem::is_regular_file(preset_file, error)) {
        std::vector<std::string> known;
        for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(preset_file).parent_path(), error))
            known.push_back(entry.path().stem().string());
        std::sort(known.begin(), known.end());
        in.refuse("preset", fmt::format("'{}' is not a material; there are: {}", name, fmt::join(known, ", ")));
    }
    toml::table preset = parse(preset_file);
    material->erase("preset");
    overlay(preset, std::move(*material));
    table.insert_or_assign("material", std::move(preset));
}

Study::Material read_material(TomlReader in, const Study::Geometry& geometry) {
    Study::Material m;
    m.law = in.choice("law", {"mooney-rivlin", "neo-Hookean", "ogden"});
    if (geometry.is_solid() && m.law == "ogden")
        in.refuse("law", "'ogden' is for the plane alone; a solid block has mooney-rivlin or neo-Hookean");
    static_cast<Study::LawParameters&>(m) = read_law_parameters(in, m.law);
    m.density_kg_m3 = in.number("density_kg_m3", positive);
    if (geometry.is_solid()) {
        if (in.has("formulation")) in.refuse("formulation", "belongs to the plane; a solid block is incompressible");
        if (in.has("regions")) in.refuse("regions", "needs a geometry.shape whose file names them; a solid block has [nodule]");
        m.formulation = "incompressible";
    } else {
        m.formulation = in.choice("formulation", {"plane-stress", "plane-strain"});
    }
    if (in.has("regions")) {
        if (geometry.is_block()) in.refuse("regions", "needs a geometry.shape whose file names them");
        TomlReader regions = in.table("regions");
        for (const std::string& name : regions.keys()) {
            TomlReader region = regions.table(name);
            m.regions.push_back({read_law_parameters(region, m.law, m.alpha.size()), name});
            region.refuse_the_rest();
        }
    }
    in.refuse_the_rest();
    return m;
}

Study::Loads read_magnitudes(TomlReader& in) {
    Study::Loads loads;
    loads.magnitudes_m = in.numbers("magnitudes_m", positive);
    loads.record_step_m = in.number("record_step_m", positive);
    for (std::size_t i = 0; i < loads.magnitudes_m.size(); ++i) {
        if (i > 0 && !(loads.magnitudes_m[i] > loads.magnitudes_m[i - 1]))
            in.refuse("magnitudes_m", "must be ascending");
        if (!is_multiple(loads.magnitudes_m[i], loads.record_step_m))
            in.refuse("magnitudes_m", "every entry must be a multiple of record_step_m");
    }
    return loads;
}

Study::Loads read_loads(TomlReader in, const Study::Geometry& geometry, const Study::Indenter& indenter) {
    Study::Loads loads = read_magnitudes(in);
    if (in.has("sweep")) {
        in.refuse_unless_empty("paths", "must be empty beside a sweep");
        TomlReader sweep = in.table("sweep");
        const bool listed = sweep.has("arcs_m");
        if (listed && sweep.has("spacing_m")) sweep.refuse("arcs_m", "cannot stand beside spacing_m: contacts are listed or spaced");
        const double spacing_m = listed ? 0 : sweep.number("spacing_m", positive);
        loads.sweep = Study::Loads::Sweep{spacing_m, sweep.number("clearance_m", {0.015}), sweep.numbers("angles_deg", {-75, 75})};
        if (listed) loads.sweep->arcs_m = sweep.numbers("arcs_m", positive);
        for (std::size_t i = 1; i < loads.sweep->arcs_m.size(); ++i)
            if (!(loads.sweep->arcs_m[i] > loads.sweep->arcs_m[i - 1])) sweep.refuse("arcs_m", "must be ascending");
        for (std::size_t i = 1; i < loads.sweep->angles_deg.size(); ++i)
            if (!(loads.sweep->angles_deg[i] > loads.sweep->angles_deg[i - 1]))
                sweep.refuse("angles_deg", "must be ascending");
        for (std::size_t i = 0, n = loads.sweep->angles_deg.size(); geometry.is_block() && i < n; ++i)
            if (loads.sweep->angles_deg[i] != -loads.sweep->angles_deg[n - 1 - i])
                sweep.refuse("angles_deg", "must be symmetric about 0, as the block mirrors itself");
        sweep.refuse_the_rest();
        in.refuse_the_rest();
        return loads;
    }
    if (in.tables("paths").empty()) in.refuse("paths", "must not be empty without a sweep");
    std::set<std::string> names;
    for (TomlReader& path : in.tables("paths")) {
        StudyPath p;
        p.name = path.text("name");
        if (!is_plain_name(p.name)) path.refuse("name", "must be of lower-case letters, digits and '-'");
        if (!names.insert(p.name).second) path.refuse("name", "'" + p.name + "' stands twice");
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
        // next to the held edge a patch tears rather than dents; FE there is of no use to train on
        constexpr double clearance_m = 0.015;
        if (geometry.is_block() && indenter.kind == "patch" && on_side && !on_top && y < clearance_m)
            path.refuse("contact_m", fmt::format("is {:g} mm from the fixed edge; a patch needs {:g} mm", 1e3 * y,
                                                 1e3 * clearance_m));
        path.refuse_the_rest();
        loads.paths.push_back(p);
    }
    in.refuse_the_rest();
    return loads;
}

Study::Springs read_springs(TomlReader in, const Study::Geometry& geometry, bool measured) {
    Study::Springs s;
    s.topology = in.choice("topology", topologies_of(geometry));
    s.stiffness = in.has("stiffness") ? in.choice("stiffness", {"sets", "law"}) : "sets";
    if (geometry.is_solid() && !s.is_law()) in.refuse("stiffness", "must be \"law\" on a solid block: sets are of the plane");
    if (measured && !s.is_law())
        in.refuse("stiffness", "must be \"law\" beside [data]: sets are trained on nodes inside, and none was measured");
    if (!s.is_law()) {
        for (const char* key : {"terms", "area_cap_E2"})
            if (in.has(key)) in.refuse(key, "belongs to stiffness = \"law\"");
        s.law = in.choice("law", spring_laws().names());
        in.refuse_the_rest();
        return s;
    }
    if (in.has("law")) in.refuse("law", "belongs to stiffness = \"sets\": springs of an energy turn with the tissue");
    if (s.topology == "grid4") in.refuse("topology", "'grid4' cannot carry a law: without diagonals its springs shear for nothing");
    s.law = "geometric";
    s.terms = in.texts("terms");
    if (s.terms.empty()) in.refuse("terms", "must name at least one term (lib/springs/energy_law.h)");
    std::set<std::string> known;
    for (const std::string& term : s.terms)
        if (!known.insert(term).second) in.refuse("terms", "'" + term + "' stands twice");
    s.area_cap_E2 = in.optional_number("area_cap_E2", area_caps).value_or(12);
    in.refuse_the_rest();
    return s;
}

/// Of a law: the defaults are LawTrainingOptions', whose scales are what FE itself and an eye leave open.
Study::Training read_law_training(TomlReader in, bool measured) {
    for (const char* key : sets_keys)
        if (in.has(key) && std::string(key) != "ridge") in.refuse(key, "belongs to springs.stiffness = \"sets\"");
    if (measured && in.has("shape_scale"))
        in.refuse("shape_scale", "belongs to finite elements: nothing inside was measured");
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
    for (const char* key : law_keys)
        if (in.has(key) && std::string(key) != "ridge") in.refuse(key, "belongs to springs.stiffness = \"law\"");
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

void read_seed_and_count(TomlReader& draw, Study::Draws& d) {
    d.seed = static_cast<unsigned long>(draw.integer("seed", 0, std::numeric_limits<int>::max()));
    d.count = static_cast<int>(draw.integer("count", 1, 100'000));
}

void read_depth(TomlReader& draw, const Study& study, Study::Draws& d) {
    const std::vector<double> depth = draw.numbers("depth_m", 2, positive);
    if (depth[0] > depth[1] || depth[1] > study.loads.depth_m())
        draw.refuse("depth_m", "must be [smallest, largest], the largest not beyond loads.magnitudes_m");
    std::copy(depth.begin(), depth.end(), d.depth_m);
}

/// Puts it among the study's draws, none of which has its seed.
void add_draws(const TomlReader& draw, const Study::Draws& d, Study& study) {
    for (const Study::Draws& other : study.draws)
        if (other.seed == d.seed) draw.refuse("seed", "is also that of '" + other.role + "': the draws would overlap");
    draw.refuse_the_rest();
    study.draws.push_back(d);
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

Study::Solver read_solver(TomlReader solver) {
    const Study::Solver s{solver.number("tolerance", {1e-13, 1e-3}), static_cast<int>(solver.integer("max_newton", 2, 100))};
    solver.refuse_the_rest();
    return s;
}

/// What finite elements need.
void read_fe(TomlReader& in, Study& study) {
    TomlReader mesh = in.table("mesh");
    study.refine = static_cast<int>(mesh.integer("refine", 1, 100));
    const bool block = study.geometry.is_block();
    if (block && study.cells[0] * study.refine % 2 != 0)
        mesh.refuse("refine", "times lattice.cells[0] must be even, so that the two halves mirror each other");
    study.check_refine = static_cast<int>(mesh.optional_integer("check_refine", 0, 100).value_or(0));
    study.check_fraction = mesh.optional_number("check_fraction", {0, 1}).value_or(1);
    if (study.check_refine != 0 && study.check_refine <= study.refine)
        mesh.refuse("check_refine", "must be 0 or larger than refine");
    if (block && study.cells[0] * study.check_refine % 2 != 0)
        mesh.refuse("check_refine", "times lattice.cells[0] must be even, so that the two halves mirror each other");
    mesh.refuse_the_rest();

    TomlReader indenter = in.table("indenter");
    study.indenter.kind = indenter.choice("kind", {"point", "patch"});
    const bool patch = study.indenter.kind == "patch";
    study.indenter.half_width_m = patch ? indenter.number("half_width_m", positive) : 0;
    indenter.refuse_the_rest();
    // the ends of a patch become FE nodes by sliding those there are; longer elements have none to slide
    if (patch && study.spring_size_m / study.refine > 1.001 * study.indenter.half_width_m)
        mesh.refuse("refine", "must make finite elements, lattice.size_m / refine, no longer than indenter.half_width_m");

    study.solver = read_solver(in.table("solver"));
    study.loads = read_loads(in.table("loads"), study.geometry, study.indenter);
}

// ---- solid blocks

/// A name a path: place in 0.1 mm, tilt and azimuth in degrees, all with as many more decimals as tell all of them apart.
void name_paths(std::vector<StudyPath>& paths, const std::vector<std::array<double, 2>>& pushes_deg) {
    constexpr int most_decimals = 6;  // places lie 1e-9 m apart
    for (int decimals = 0; decimals <= most_decimals; ++decimals) {
        const double scale = std::pow(10, decimals);
        std::set<std::string> names;
        for (std::size_t i = 0; i < paths.size(); ++i) {
            paths[i].name = fmt::format("x{:0{}.0f}-y{:0{}.0f}-t{:0{}.0f}-a{:0{}.0f}", 1e4 * scale * paths[i].contact_m[0], 4 + decimals,
                                        1e4 * scale * paths[i].contact_m[1], 4 + decimals, scale * pushes_deg[i][0], 2 + decimals,
                                        scale * pushes_deg[i][1], 3 + decimals);
            names.insert(paths[i].name);
        }
        if (names.size() == paths.size()) return;
    }
}

/// A ball well inside the block: half an element from every wall, or the mesh has slivers.
Study::Nodule read_nodule(TomlReader in, const Study& study) {
    const Study::Geometry& g = study.geometry;
    const std::vector<double> centre = in.numbers("centre_m", 3);
    const double radius_m = in.number("radius_m", positive);
    Study::Nodule nodule{read_law_parameters(in, study.material.law), Eigen::Vector3d(centre[0], centre[1], centre[2]), radius_m};
    const double least_m = radius_m + study.sizes_m[0] / 2;
    double wall_m = std::numeric_limits<double>::infinity();
    for (const auto& [place_m, size_m] :
         {std::pair(centre[0], g.width_m), std::pair(centre[1], g.length_m), std::pair(centre[2], g.height_m)})
        wall_m = std::min({wall_m, place_m, size_m - place_m});
    if (wall_m < least_m - tiny_m)
        in.refuse("radius_m", fmt::format("the nodule's middle is {:g} mm from a wall of the {:g} x {:g} x {:g} m block; a nodule of "
                                          "{:g} mm needs {:g} mm, half of mesh.sizes_m[0] more than its radius",
                                          1e3 * wall_m, g.width_m, g.length_m, g.height_m, 1e3 * radius_m, 1e3 * least_m));
    in.refuse_the_rest();
    return nodule;
}

/// [near, far] of a solid's finite elements.
std::array<double, 2> read_sizes(TomlReader& in, const char* key, const Study::Indenter& indenter) {
    constexpr double longest_m = 0.010;  // near elements; half of it lies between disc and wall
    const std::vector<double> sizes = in.numbers(key, 2, positive);
    if (sizes[0] > sizes[1]) in.refuse(key, "must be [near, far], the elements at the contact no longer than those far away");
    if (sizes[0] > std::min(indenter.radius_m, longest_m))
        in.refuse(key, fmt::format("elements at the contact must be no longer than indenter.radius_m, nor than {:g} mm", 1e3 * longest_m));
    return {sizes[0], sizes[1]};
}

/// "contacts[2]" stands in messages as loads.contacts[2]. Every push of every contact, in the order in which they stand.
std::vector<StudyPath> read_contacts(TomlReader& in, const Study& study) {
    const Study::Geometry& g = study.geometry;
    const Study::Loads& loads = study.loads;
    std::vector<StudyPath> paths;
    std::vector<std::array<double, 2>> pushes_deg;  // of each path, for its name
    if (in.tables("contacts").empty()) in.refuse("contacts", "must not be empty");
    for (TomlReader& contact : in.tables("contacts")) {
        const std::vector<double> at = contact.numbers("at_m", 2);
        const double wall_m = std::min({at[0], g.width_m - at[0], at[1], g.length_m - at[1]});
        if (wall_m < study.indenter.clearance_m() - tiny_m)
            contact.refuse("at_m", fmt::format("({:g}, {:g}) m is {:g} mm from a wall of the {:g} x {:g} m top; a disc of radius {:g} mm needs {:g} mm",
                                               at[0], at[1], 1e3 * wall_m, g.width_m, g.length_m, 1e3 * study.indenter.radius_m,
                                               1e3 * study.indenter.clearance_m()));
        const double depth_m = contact.optional_number("depth_m", positive).value_or(loads.depth_m());
        if (depth_m > loads.depth_m()) contact.refuse("depth_m", "must not be beyond loads.magnitudes_m");
        if (depth_m > loads.magnitudes_m.front() && !is_multiple(depth_m, loads.record_step_m))
            contact.refuse("depth_m", "must be a multiple of loads.record_step_m, or not beyond the smallest of loads.magnitudes_m");
        for (const std::vector<double>& push : contact.rows("pushes_deg", 2)) {
            if (!(push[0] >= 0 && push[0] <= 90)) contact.refuse("pushes_deg", fmt::format("a tilt of {:g} degrees is not from 0 to 90", push[0]));
            if (!(std::abs(push[1]) <= 360)) contact.refuse("pushes_deg", fmt::format("an azimuth of {:g} degrees is not from -360 to 360", push[1]));
            const Eigen::Vector3d place(at[0], at[1], g.height_m), direction = solid_push(push[0], push[1]);
            for (const StudyPath& p : paths)
                if ((p.contact_m - place).norm() < tiny_m && (p.direction - direction).norm() < tiny_direction)
                    contact.refuse("pushes_deg", fmt::format("({:g}, {:g}) m is pushed at ({:g}, {:g}) degrees twice", at[0], at[1], push[0], push[1]));
            paths.push_back({"", place, direction, depth_m});
            pushes_deg.push_back({push[0], push[0] == 0 ? 0 : push[1] < 0 ? push[1] + 360 : push[1]});
        }
        contact.refuse_the_rest();
    }
    name_paths(paths, pushes_deg);
    return paths;
}

Study::Map read_map(TomlReader in, const Study& study) {
    Study::Map map;
    map.depth_m = in.number("depth_m", positive);
    if (map.depth_m > study.loads.depth_m()) in.refuse("depth_m", "must not be beyond loads.magnitudes_m");
    const auto places = [&](const char* key, double size_m) {
        const std::vector<double> at = in.numbers(key);
        const double least_m = study.indenter.clearance_m();
        if (at.size() < 2) in.refuse(key, "must have two entries at least");
        for (std::size_t i = 1; i < at.size(); ++i)
            if (!(at[i] > at[i - 1] + tiny_m)) in.refuse(key, "must be ascending");
        if (at.front() < least_m - tiny_m || at.back() > size_m - least_m + tiny_m)
            in.refuse(key, fmt::format("a disc of radius {:g} mm needs {:g} mm from every wall", 1e3 * study.indenter.radius_m, 1e3 * least_m));
        return at;
    };
    map.x_m = places("x_m", study.geometry.width_m);
    map.y_m = places("y_m", study.geometry.length_m);
    in.refuse_the_rest();
    return map;
}

/// validation, held_out, or held_out_WORD.
bool is_role(const std::string& role) {
    const std::string held_out = "held_out";
    if (role == "validation" || role == held_out) return true;
    return role.rfind(held_out + "_", 0) == 0 && role.size() > held_out.size() + 1 && role.back() != '_' &&
           role.find("__") == std::string::npos &&
           role.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos;
}

void read_solid_draws(TomlReader in, Study& study) {
    const Study::Geometry& g = study.geometry;
    std::vector<std::string> roles = {"validation", "held_out"};
    for (const std::string& role : in.keys())
        if (!is_role(role)) in.refuse(role, "is not a role; allowed: validation, held_out, held_out_WORD of lower-case letters and '_'");
        else if (role != "validation" && role != "held_out") roles.push_back(role);
    for (const std::string& role : roles) {
        if (!in.has(role)) continue;
        TomlReader draw = in.table(role);
        Study::Draws d{};
        d.role = role;
        read_seed_and_count(draw, d);
        read_depth(draw, study, d);
        const std::vector<double> tilt = draw.numbers("tilt_deg", 2, {0, 90}), clearance = draw.numbers("clearance_m", 2, positive);
        if (tilt[0] > tilt[1]) draw.refuse("tilt_deg", "must be [smallest, largest]");
        if (!(clearance[0] < clearance[1])) draw.refuse("clearance_m", "must be [smallest, largest], not the same");
        if (clearance[0] < study.indenter.clearance_m() - tiny_m)
            draw.refuse("clearance_m", fmt::format("a disc of radius {:g} mm needs {:g} mm from every wall", 1e3 * study.indenter.radius_m,
                                                   1e3 * study.indenter.clearance_m()));
        if (!(clearance[0] < std::min(g.width_m, g.length_m) / 2))
            draw.refuse("clearance_m", fmt::format("no place of the {:g} x {:g} m top is so far from every wall", g.width_m, g.length_m));
        std::copy(tilt.begin(), tilt.end(), d.tilt_deg);
        std::copy(clearance.begin(), clearance.end(), d.clearance_m);
        add_draws(draw, d, study);
    }
    in.refuse_the_rest();
}

/// What finite elements need in space.
void read_solid_fe(TomlReader& in, Study& study) {
    TomlReader indenter = in.table("indenter");
    study.indenter.kind = indenter.text("kind");
    if (study.indenter.kind != "disc") indenter.refuse("kind", "'" + study.indenter.kind + "' is for the plane; a solid block has disc");
    study.indenter.radius_m = indenter.number("radius_m", positive);
    indenter.refuse_the_rest();

    TomlReader mesh = in.table("mesh");
    for (const char* key : {"refine", "check_refine"})
        if (mesh.has(key)) mesh.refuse(key, "belongs to the plane; a solid block has sizes_m and check_sizes_m");
    study.sizes_m = read_sizes(mesh, "sizes_m", study.indenter);
    if (mesh.has("check_sizes_m")) {
        study.check_sizes_m = read_sizes(mesh, "check_sizes_m", study.indenter);
        for (int i : {0, 1})
            if (!(study.check_sizes_m[i] < study.sizes_m[i])) mesh.refuse("check_sizes_m", "must both be smaller than those of sizes_m");
    }
    study.check_fraction = mesh.optional_number("check_fraction", {0, 1}).value_or(1);
    mesh.refuse_the_rest();

    if (in.has("nodule")) study.nodule = read_nodule(in.table("nodule"), study);
    study.solver = read_solver(in.table("solver"));

    TomlReader loads = in.table("loads");
    for (const char* key : {"sweep", "paths"})
        if (loads.has(key)) loads.refuse(key, "belongs to the plane; a solid block has contacts");
    study.loads = read_magnitudes(loads);
    study.loads.paths = read_contacts(loads, study);
    loads.refuse_the_rest();

    if (in.has("map")) {
        if (!study.nodule) in.refuse("map", "shows a nodule, and there is none");
        study.map = read_map(in.table("map"), study);
    }
}

/// Measured contacts, in place of all that.
void read_data(TomlReader& in, Study& study) {
    for (const char* key : {"mesh", "indenter", "solver", "loads", "draws", "variants"})
        if (in.has(key)) in.refuse(key, "belongs to finite elements; a study with [data] has none");
    TomlReader data = in.table("data");
    Study::Data d;
    d.file = (std::filesystem::path(study.file).parent_path() / data.text("file")).lexically_normal().string();
    d.seed = static_cast<unsigned long>(data.integer("seed", 0, std::numeric_limits<int>::max()));
    d.validation_part = data.number("validation_part", {0, 0.5});
    d.held_out_part = data.number("held_out_part", {0, 0.5, true});
    d.surface_tolerance_m = data.optional_number("surface_tolerance_m", not_negative).value_or(0.0005);
    d.stated_force_noise = data.optional_number("stated_force_noise", not_negative);
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
        v.first_paths = static_cast<int>(in.optional_integer("first_paths", 1, static_cast<long>(study.loads.paths.size())).value_or(0));
    } else {
        v.arcs_m = some_of("arcs_m", v.arcs_m);
        v.angles_deg = some_of("angles_deg", v.angles_deg);
    }
    v.magnitudes_m = some_of("magnitudes_m", v.magnitudes_m);
    in.refuse_the_rest();
    return v;
}

}  // namespace

double Study::LawParameters::youngs_modulus_Pa() const {
    if (alpha.empty()) return 6 * (C1_Pa + C2_Pa);
    double twice_mu = 0;
    for (std::size_t k = 0; k < alpha.size(); ++k) twice_mu += mu_Pa[k] * alpha[k];
    return 3 * twice_mu / 2;
}

std::vector<std::string> Study::Material::region_names() const {
    std::vector<std::string> names;
    for (const Region& r : regions) names.push_back(r.name);
    return names;
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

    study.geometry = read_geometry(in.table("geometry"), table, file);
    study.material = read_material(in.table("material"), study.geometry);
    const bool block = study.geometry.is_block(), solid = study.geometry.is_solid();
    if (block) {
        TomlReader lattice = in.table("lattice");
        const std::vector<double> cells = lattice.numbers("cells", solid ? 3 : 2, {1, 2000});
        study.cells.assign(cells.begin(), cells.end());
        if (!std::equal(cells.begin(), cells.end(), study.cells.begin())) lattice.refuse("cells", "must be whole numbers");
        lattice.refuse_the_rest();
    } else if (ends_with(study.geometry.shape, ".geo")) {
        TomlReader lattice = in.table("lattice");
        study.spring_size_m = lattice.number("size_m", positive);
        lattice.refuse_the_rest();
    } else if (in.has("lattice")) {
        in.refuse("lattice", "is for the block, or a shape that is a .geo; a .msh has its triangles already");
    }

    if (in.has("data") && !block) in.refuse("data", "is measured on the block; a shape has finite elements");
    if (in.has("data") && solid) in.refuse("data", "is measured in the plane; a solid block has finite elements");
    for (const char* key : {"nodule", "map"})
        if (in.has(key) && !solid) in.refuse(key, "needs a solid block, one with geometry.length_m");
    if (in.has("data"))
        read_data(in, study);
    else if (solid)
        read_solid_fe(in, study);
    else
        read_fe(in, study);

    study.springs = read_springs(in.table("springs"), study.geometry, study.data.has_value());
    const bool law = study.springs.is_law();
    const toml::table nothing;  // a law has a default for every key
    if (law) {
        const TomlReader training = in.has("training") ? in.table("training") : TomlReader(nothing, file, "training");
        study.training = read_law_training(training, study.data.has_value());
    } else
        study.training = read_training(in.table("training"));
    if (in.has("draws")) {
        if (!solid && !study.loads.sweep) in.refuse("draws", "needs a study with loads.sweep");
        if (solid) read_solid_draws(in.table("draws"), study);
        else read_draws(in.table("draws"), study);
    }
    if (in.has("variants")) {
        if (!law) in.refuse("variants", "are of a law; this study's stiffness is sets");
        if (!solid && !study.loads.sweep) in.refuse("variants", "needs a study with loads.sweep");
        for (const TomlReader& variant : in.tables("variants")) study.variants.push_back(read_variant(variant, study));
    }
    in.refuse_the_rest();
    return study;
}

}  // namespace tissue
