#include "study/based_on.h"

#include <fmt/format.h>

#include <filesystem>
#include <functional>

#include "error.h"
#include "io/atomic_file.h"
#include "io/one_line.h"
#include "study/toml_reader.h"

namespace tissue {
namespace {

/// Whether a rule applies to a study over a base.
using Applies = std::function<bool(const toml::table& study, const toml::table& base)>;

struct Rule : BaseRule {
    Applies applies;
};

Applies gives(const std::string& key) {
    return [key](const toml::table& study, const toml::table&) { return static_cast<bool>(study.at_path(key)); };
}

Applies gives(const std::string& key, const std::string& text) {
    return [key, text](const toml::table& study, const toml::table&) { return study.at_path(key).value<std::string>() == text; };
}

Applies either(Applies a, Applies b) {
    return [a = std::move(a), b = std::move(b)](const toml::table& study, const toml::table& base) { return a(study, base) || b(study, base); };
}

bool gives_file(const toml::table& study, const toml::table&) {
    const auto shape = study["geometry"]["shape"].value<std::string>();
    return shape && *shape != "block";
}

bool gives_list(const toml::table& study, const char* table, const char* key, bool empty) {
    const toml::array* list = study[table][key].as_array();
    return list && list->empty() == empty;
}

bool in_space(const toml::table& tables) {
    return tables["geometry"]["length_m"] || tables["geometry"]["solid"];
}

/// Keys of [training] that belong to one kind of stiffness alone. `ridge` is in both lists, because its meaning
/// differs.
const std::vector<std::string> sets_keys = {"training.optimizer",   "training.also",            "training.objective",
                                            "training.ridge",       "training.iterations",      "training.max_seconds",
                                            "training.target_rel_loss", "training.k_min_E2",    "training.k_max_E2",
                                            "training.weight_near", "training.weight_far"};
const std::vector<std::string> energy_model_keys = {"training.force_scale", "training.shape_scale", "training.starts", "training.ridge"};

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

const std::vector<Rule>& rules() {
    static const std::vector<Rule> all = {
        {{"`geometry.shape` = a file",
          {"geometry.width_m", "geometry.height_m", "geometry.length_m", "geometry.trust_geo", "geometry.bed_Pa_m", "lattice", "springs.spacing_m", "nodule", "map"},
          "size, bed, lattice and nodule belong to the base's tissue; trust belongs to one file"},
         gives_file},
        {{"`geometry.shape` = \"block\"", {"geometry.unit_m", "geometry.fixed", "geometry.bed_Pa_m", "geometry.solid", "geometry.trust_geo", "lattice"}, "they belong to a shape"},
         gives("geometry.shape", "block")},
        {{"`geometry.length_m` or `geometry.solid`, over a base in the plane",
          {"geometry.thickness_m", "material.formulation", "mesh", "indenter", "loads", "draws", "histories", "springs", "training", "variants",
           "data"},
          "they belong to the plane"},
         [](const toml::table& study, const toml::table& base) { return in_space(study) && !in_space(base); }},
        {{"`geometry.thickness_m`, over a base in space",
          {"geometry.length_m", "geometry.solid", "mesh", "indenter", "loads", "draws", "histories", "springs", "training", "variants", "nodule",
           "map"},
          "they belong to space"},
         [](const toml::table& study, const toml::table& base) { return study["geometry"]["thickness_m"] && !in_space(study) && in_space(base); }},
        {{"`material.preset`",
          {"material.law", "material.C1_Pa", "material.C2_Pa", "material.mu_Pa", "material.alpha", "material.density_kg_m3", "material.regions",
           "material.viscosity", "material.moduli"},
          "the preset has its own; regions and Maxwell branches belong to the base's tissue"},
         gives("material.preset")},
        {{"`material.law`", {"material.preset", "material.regions", "material.viscosity", "material.moduli"}, "they belong to the base's tissue"},
         gives("material.law")},
        {{"`material.law` = \"mooney-rivlin\"", {"material.mu_Pa", "material.alpha"}, "they belong to Ogden's law"}, gives("material.law", "mooney-rivlin")},
        {{"`material.law` = \"neo-Hookean\"", {"material.C2_Pa", "material.mu_Pa", "material.alpha"}, "they belong to other laws"},
         gives("material.law", "neo-Hookean")},
        {{"`material.law` = \"ogden\"", {"material.C1_Pa", "material.C2_Pa"}, "they belong to other laws"}, gives("material.law", "ogden")},
        {{"`material.preset`, `law` or `viscosity`", {"material.regions.*.viscosity", "nodule.viscosity"}, "their `tau_s` belong to the base"},
         either(gives("material.preset"), either(gives("material.law"), gives("material.viscosity")))},
        {{"`material.viscosity` = []", {"material.moduli"}, "elastic tissue has no `moduli`"},
         [](const toml::table& study, const toml::table&) { return gives_list(study, "material", "viscosity", true); }},
        {{"`springs.topology`, not \"embedded\"", {"springs.spacing_m"}, "it belongs to an embedded lattice"},
         [](const toml::table& study, const toml::table&) {
             const auto topology = study["springs"]["topology"].value<std::string>();
             return topology && *topology != "embedded";
         }},
        {{"`springs.stiffness` = \"law\"", std::vector<std::string>{"springs.law", "variants"} + sets_keys, "they belong to spring sets"},
         gives("springs.stiffness", "law")},
        {{"`springs.stiffness` = \"sets\"", std::vector<std::string>{"springs.terms", "springs.area_cap_E2", "springs.curve", "variants"} + energy_model_keys,
          "they belong to an energy model"},
         gives("springs.stiffness", "sets")},
        {{"`nodule.shape`", {"nodule.centre_m", "nodule.radius_m"}, "they belong to a ball"}, gives("nodule.shape")},
        {{"`nodule.centre_m`", {"nodule.shape"}, "a ball has no file"}, gives("nodule.centre_m")},
        {{"`data`", {"mesh", "indenter", "solver", "loads", "draws", "histories", "variants", "nodule", "map", "training.shape_scale"},
          "a study of measured forces has no finite elements"},
         gives("data")},
        {{"`indenter.kind` = \"point\"", {"indenter.half_width_m"}, "a point has no width"}, gives("indenter.kind", "point")},
        {{"`loads.sweep`", {"loads.paths"}, "contacts are swept or listed"}, gives("loads.sweep")},
        {{"`loads.paths`, not empty", {"loads.sweep", "draws", "variants"}, "contacts are listed; draws and variants need a sweep"},
         [](const toml::table& study, const toml::table&) { return gives_list(study, "loads", "paths", false); }},
        {{"`loads.contacts`", {"loads.spread", "variants"}, "contacts are listed; variants refer to the base's contacts"}, gives("loads.contacts")},
        {{"`loads.spread`", {"loads.contacts", "variants"}, "contacts are spread; variants refer to the base's contacts"}, gives("loads.spread")},
        {{"`loads.sweep.spacing_m`", {"loads.sweep.arcs_m"}, "contacts are spaced"}, gives("loads.sweep.spacing_m")},
        {{"`loads.sweep.arcs_m`", {"loads.sweep.spacing_m"}, "contacts are listed"}, gives("loads.sweep.arcs_m")},
    };
    return all;
}

/// Erases the key "a.b.c"; '*' in place of a part stands for every name.
void erase(toml::table& table, const std::string& key) {
    const std::size_t dot = key.find('.');
    if (dot == std::string::npos) {
        table.erase(key);
        return;
    }
    const std::string first = key.substr(0, dot), rest = key.substr(dot + 1);
    for (auto&& [name, node] : table)
        if ((first == "*" || name.str() == first) && node.is_table()) erase(*node.as_table(), rest);
}

toml::table parse_chain(const std::string& file, int depth) {
    constexpr int deepest = 8;
    toml::table table = parse_study_file(file);
    const toml::node* based_on = table.get("based_on");
    if (!based_on) return table;
    if (!based_on->is_string() || depth > deepest)
        throw StudyError(one_line(fmt::format("{}:{}: key 'based_on': must name another study, without a circle", file,
                                              based_on->source().begin.line)));
    const std::filesystem::path path = std::filesystem::path(file).parent_path() / (based_on->as_string()->get() + ".toml");
    toml::table base = parse_chain(path.string(), depth + 1);
    table.erase("based_on");
    std::vector<const Rule*> applied;  // collected before any key is dropped, so that no rule depends on another
    for (const Rule& rule : rules())
        if (rule.applies(table, base)) applied.push_back(&rule);
    for (const Rule* rule : applied)
        for (const std::string& key : rule->dropped) erase(base, key);
    underlay(table, std::move(base));
    return table;
}

}  // namespace

std::vector<BaseRule> base_rules() {
    return {rules().begin(), rules().end()};
}

toml::table parse_study_file(const std::string& file) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) throw FileError(one_line(file) + ": there is no such study file");
    return parse_toml(read_file(file), file);
}

void underlay(toml::table& table, toml::table&& base) {
    for (auto&& [key, node] : base) {
        toml::node* there = table.get(key);
        if (there && there->is_table() && node.is_table())
            underlay(*there->as_table(), std::move(*node.as_table()));
        else if (!there)
            node.visit([&, name = std::string(key.str())](auto&& value) { table.insert(name, std::move(value)); });
    }
}

toml::table parse_with_base(const std::string& file) {
    return parse_chain(file, 0);
}

}  // namespace tissue
