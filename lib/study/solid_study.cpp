#include "study/solid_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "error.h"
#include "study/read_parts.h"
#include "study/solid_push.h"
#include "study/viscosity.h"
#include "surface_file/surface_file.h"
#include "surface_file/vtk_file.h"

namespace tissue {
namespace {

// Tolerances of equal ratios, places and directions.
constexpr double tiny = 1e-9, tiny_m = 1e-9, tiny_direction = 1e-9;

/// Names the paths by place in 0.1 mm, tilt and azimuth in degrees and, where the disc's radius is not own_m, its
/// radius in 0.1 mm. All numbers get as many further decimals as make the names different.
void name_paths(std::vector<StudyPath>& paths, const std::vector<std::array<double, 2>>& pushes_deg, double own_m) {
    constexpr int most_decimals = 6;  // different places are at least 1e-9 m apart
    for (int decimals = 0; decimals <= most_decimals; ++decimals) {
        const double scale = std::pow(10, decimals);
        std::set<std::string> names;
        for (std::size_t i = 0; i < paths.size(); ++i) {
            paths[i].name = fmt::format("x{:0{}.0f}-y{:0{}.0f}-t{:0{}.0f}-a{:0{}.0f}", 1e4 * scale * paths[i].contact_m[0], 4 + decimals,
                                        1e4 * scale * paths[i].contact_m[1], 4 + decimals, scale * pushes_deg[i][0], 2 + decimals,
                                        scale * pushes_deg[i][1], 3 + decimals);
            if (paths[i].radius_m != own_m) paths[i].name += fmt::format("-r{:0{}.0f}", 1e4 * scale * paths[i].radius_m, 3 + decimals);
            names.insert(paths[i].name);
        }
        if (names.size() == paths.size()) return;
    }
}

/// The inclusion that the surface of a file encloses. cases/study_mesh.h checks that it lies in the shape, once the
/// shape is meshed.
Study::Nodule read_enclosed_nodule(TomlReader& in, const Study& study) {
    const std::string shape = in.text("shape");
    if (study.geometry.is_block()) in.refuse("shape", "needs a tissue with geometry.shape; in a block a nodule is a ball with centre_m and radius_m");
    if (in.has("centre_m") || in.has("radius_m")) in.refuse("shape", "is not possible with centre_m and radius_m, which are for a ball");
    if (const std::string why = vtk_refusal(in.beside("shape", shape)); !why.empty()) in.refuse("shape", why);
    if (!is_surface_file(shape)) in.refuse("shape", fmt::format("'{}' must be a file that ends in {}", shape, surface_endings));
    const std::string file = file_beside(in, "shape", shape);
    try {
        return {read_material_parameters(in, study.material.law, study.material.alpha.size()), Inclusion(inclusion_surface(read_surface_file(file), study.geometry.unit_m)), file};
    } catch (const FileError& e) {
        in.refuse("shape", e.what());
    }
}

/// [nodule]. A ball in a block keeps half an element from every wall; otherwise the mesh would have slivers.
Study::Nodule read_nodule(TomlReader in, const Study& study) {
    const Study::Geometry& g = study.geometry;
    if (in.has("shape")) {
        Study::Nodule nodule = read_enclosed_nodule(in, study);
        read_own_viscosity(in, study.material, nodule);
        in.refuse_the_rest();
        return nodule;
    }
    const std::vector<double> centre = in.numbers("centre_m", 3);
    const double radius_m = in.number("radius_m", positive);
    Study::Nodule nodule{read_material_parameters(in, study.material.law, study.material.alpha.size()), Inclusion(Eigen::Vector3d(centre[0], centre[1], centre[2]), radius_m), {}};
    read_own_viscosity(in, study.material, nodule);
    if (!g.is_block()) {
        in.refuse_the_rest();
        return nodule;
    }
    const double least_m = radius_m + study.sizes_m[0] / 2;
    double wall_m = std::numeric_limits<double>::infinity();
    for (const auto& [place_m, size_m] :
         {std::pair(centre[0], g.width_m), std::pair(centre[1], g.length_m), std::pair(centre[2], g.height_m)})
        wall_m = std::min({wall_m, place_m, size_m - place_m});
    if (wall_m < least_m - tiny_m)
        in.refuse("radius_m", fmt::format("the nodule's centre is {:g} mm from a wall of the {:g} x {:g} x {:g} m block; a nodule of "
                                          "{:g} mm needs {:g} mm, half of mesh.sizes_m[0] more than its radius",
                                          1e3 * wall_m, g.width_m, g.length_m, g.height_m, 1e3 * radius_m, 1e3 * least_m));
    in.refuse_the_rest();
    return nodule;
}

/// Sizes [near, far] of a solid's finite elements [m].
std::array<double, 2> read_sizes(TomlReader& in, const char* key, const Study::Indenter& indenter) {
    constexpr double longest_m = 0.010;  // of near elements: the 5 mm between disc and wall are half of it
    const std::vector<double> sizes = in.numbers(key, 2, positive);
    if (sizes[0] > sizes[1]) in.refuse(key, "must be [near, far], the first not larger than the second");
    if (sizes[0] > std::min(indenter.radius_m, longest_m))
        in.refuse(key, fmt::format("elements at the contact must be at most as long as indenter.radius_m and {:g} mm", 1e3 * longest_m));
    return {sizes[0], sizes[1]};
}

/// The radius of a disc; exactly the study's own where it differs by less than 1e-9 m. Refused unless it is between a
/// third and three times the study's own, because near elements and largest depths are in proportion to it.
double checked_radius(const TomlReader& in, const char* key, const Study& study, double radius_m) {
    constexpr double most = 3;
    const double times = study.indenter.times(radius_m);
    if (!(times * most >= 1 - tiny && times <= most * (1 + tiny)))
        in.refuse(key, fmt::format("{:g} mm must be from a third to three times indenter.radius_m, {:g} mm", 1e3 * radius_m, 1e3 * study.indenter.radius_m));
    return std::abs(radius_m - study.indenter.radius_m) < tiny_m ? study.indenter.radius_m : radius_m;
}

/// radius_m of a contact; the study's own where the key is absent.
double read_contact_radius(TomlReader& contact, const Study& study) {
    return checked_radius(contact, "radius_m", study, contact.optional_number("radius_m", positive).value_or(study.indenter.radius_m));
}

/// radii_m, which contacts take in turn; the study's own radius where the key is absent. No radius may occur twice.
std::vector<double> read_radii(TomlReader& in, const Study& study) {
    if (!in.has("radii_m")) return {study.indenter.radius_m};
    std::vector<double> radii_m = in.numbers("radii_m", positive);
    for (std::size_t i = 0; i < radii_m.size(); ++i) {
        radii_m[i] = checked_radius(in, "radii_m", study, radii_m[i]);
        for (std::size_t j = 0; j < i; ++j)
            if (std::abs(radii_m[i] - radii_m[j]) < tiny_m) in.refuse("radii_m", fmt::format("{:g} m is present twice", radii_m[i]));
    }
    return radii_m;
}

/// depth_m of a contact. times: its disc's radius over the study's own, to which magnitudes and record steps are
/// proportional. The depth must be a multiple of the record step, or not beyond the smallest magnitude.
double read_contact_depth(TomlReader& contact, const Study::Loads& loads, double times) {
    const double depth_m = contact.optional_number("depth_m", positive).value_or(times * loads.depth_m());
    const std::string in_proportion = std::abs(times - 1) < tiny ? "" : fmt::format(" times {:g}, the ratio of its disc to indenter.radius_m", times);
    if (depth_m > times * loads.depth_m() * (1 + tiny)) contact.refuse("depth_m", "must be at most the largest of loads.magnitudes_m" + in_proportion);
    if (depth_m > times * loads.magnitudes_m.front() * (1 + tiny) && !is_multiple(depth_m, times * loads.record_step_m))
        contact.refuse("depth_m", fmt::format("must be a multiple of loads.record_step_m{0}, or at most the smallest of loads.magnitudes_m{0}", in_proportion));
    return depth_m;
}

/// A row [tilt, azimuth] of pushes_deg, checked.
std::array<double, 2> push_of(const TomlReader& in, const std::vector<double>& push) {
    if (!(push[0] >= 0 && push[0] <= 180)) in.refuse("pushes_deg", fmt::format("a tilt of {:g} degrees must be from 0 to 180", push[0]));
    if (!(std::abs(push[1]) <= 360)) in.refuse("pushes_deg", fmt::format("an azimuth of {:g} degrees must be from -360 to 360", push[1]));
    return {push[0], push[1]};
}

/// The load paths of a block: every direction of every contact, in the order of the file.
std::vector<StudyPath> read_contacts(TomlReader& in, const Study& study) {
    const Study::Geometry& g = study.geometry;
    const Study::Loads& loads = study.loads;
    std::vector<StudyPath> paths;
    std::vector<std::array<double, 2>> pushes_deg;  // tilt and azimuth of each path, for its name
    if (in.tables("contacts").empty()) in.refuse("contacts", "must not be empty");
    for (TomlReader& contact : in.tables("contacts")) {
        const std::vector<double> at = contact.numbers("at_m", 2);
        const double wall_m = std::min({at[0], g.width_m - at[0], at[1], g.length_m - at[1]}), radius_m = read_contact_radius(contact, study);
        if (wall_m < study.indenter.clearance_m(radius_m) - tiny_m)
            contact.refuse("at_m", fmt::format("({:g}, {:g}) m is {:g} mm from a wall of the {:g} x {:g} m top; a disc of radius {:g} mm needs {:g} mm",
                                               at[0], at[1], 1e3 * wall_m, g.width_m, g.length_m, 1e3 * radius_m, 1e3 * study.indenter.clearance_m(radius_m)));
        const double depth_m = read_contact_depth(contact, loads, study.indenter.times(radius_m));
        for (const std::vector<double>& row : contact.rows("pushes_deg", 2)) {
            const std::array<double, 2> push = push_of(contact, row);
            const Eigen::Vector3d place(at[0], at[1], g.height_m), direction = solid_push(push[0], push[1]);
            for (const StudyPath& p : paths)
                if ((p.contact_m - place).norm() < tiny_m && (p.direction - direction).norm() < tiny_direction && std::abs(p.radius_m - radius_m) < tiny_m)
                    contact.refuse("pushes_deg", fmt::format("({:g}, {:g}) m has the direction ({:g}, {:g}) degrees twice", at[0], at[1], push[0], push[1]));
            paths.push_back({"", place, direction, depth_m, radius_m});
            pushes_deg.push_back({push[0], push[0] == 0 ? 0 : push[1] < 0 ? push[1] + 360 : push[1]});
        }
        contact.refuse_the_rest();
    }
    name_paths(paths, pushes_deg, study.indenter.radius_m);
    return paths;
}

/// Directions of one contact of a shape. No direction may occur twice.
Study::Loads::Pushes read_pushes(TomlReader& in) {
    Study::Loads::Pushes pushes;
    for (const std::vector<double>& row : in.rows("pushes_deg", 2)) {
        const std::array<double, 2> push = push_of(in, row);
        for (const std::array<double, 2>& p : pushes)
            if ((solid_push(p[0], p[1]) - solid_push(push[0], push[1])).norm() < tiny_direction)
                in.refuse("pushes_deg", fmt::format("({:g}, {:g}) degrees are present twice", push[0], push[1]));
        pushes.push_back(push);
    }
    return pushes;
}

Study::Map read_map(TomlReader in, const Study& study) {
    Study::Map map;
    map.depth_m = in.number("depth_m", positive);
    if (map.depth_m > study.loads.depth_m()) in.refuse("depth_m", "must be at most the largest of loads.magnitudes_m");
    const auto places = [&](const char* key, double size_m) {
        const std::vector<double> at = in.numbers(key);
        const double least_m = study.indenter.clearance_m();
        if (at.size() < 2) in.refuse(key, "must have at least two entries");
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

/// Contacts of a shape, listed or spread. cases/solid_training.h finds their places.
void read_shape_contacts(TomlReader& in, Study& study) {
    Study::Loads& loads = study.loads;
    if (in.has("contacts") && in.has("spread")) in.refuse("spread", "is not possible with contacts: contacts are listed or spread");
    if (!in.has("spread")) {
        if (!in.has("contacts")) in.refuse("contacts", "is missing: a solid shape needs contacts or spread");
        if (in.tables("contacts").empty()) in.refuse("contacts", "must not be empty");
        for (TomlReader& contact : in.tables("contacts")) {
            const std::vector<double> at = contact.numbers("at_m", 3);
            const double radius_m = read_contact_radius(contact, study);
            loads.contacts.push_back({Eigen::Vector3d(at[0], at[1], at[2]), read_pushes(contact), read_contact_depth(contact, loads, study.indenter.times(radius_m)), radius_m});
            contact.refuse_the_rest();
        }
        return;
    }
    TomlReader spread = in.table("spread");
    Study::Loads::Spread s;
    s.count = static_cast<int>(spread.integer("count", 1, 10'000));
    s.clearance_m = spread.number("clearance_m", positive);
    s.radii_m = read_radii(spread, study);
    const double largest_m = *std::max_element(s.radii_m.begin(), s.radii_m.end());
    if (s.clearance_m < study.indenter.clearance_m(largest_m) - tiny_m)
        spread.refuse("clearance_m", fmt::format("a disc of radius {:g} mm needs {:g} mm to where the surface ends or turns", 1e3 * largest_m, 1e3 * study.indenter.clearance_m(largest_m)));
    s.pushes_deg = read_pushes(spread);
    const auto pushes = static_cast<long>(s.pushes_deg.size());
    s.pushes_each = static_cast<int>(spread.has("pushes_each") ? spread.integer("pushes_each", 1, pushes) : pushes);
    spread.refuse_the_rest();
    loads.spread = s;
}

/// Whether a role is validation, held_out or held_out_WORD.
bool is_role(const std::string& role) {
    const std::string held_out = "held_out";
    if (role == "validation" || role == held_out) return true;
    return role.rfind(held_out + "_", 0) == 0 && role.size() > held_out.size() + 1 && role.back() != '_' &&
           role.find("__") == std::string::npos &&
           role.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos;
}

/// apart_m of draws whose contacts are pairs of discs. Only test sets have pairs.
void read_pairs(TomlReader& draw, const Study& study, Study::Draws& d) {
    if (!study.geometry.is_block()) draw.refuse("apart_m", "gives two discs at once, which FE supports on a block only");
    if (!is_role_of_pairs(d.role)) draw.refuse("apart_m", "gives two discs at once, which need their own role held_out_WORD");
    const std::vector<double> apart = draw.numbers("apart_m", 2, positive);
    if (!(apart[0] < apart[1])) draw.refuse("apart_m", "must be [smallest, largest], not the same");
    const double largest_m = d.radii_m.empty() ? study.indenter.radius_m : *std::max_element(d.radii_m.begin(), d.radii_m.end());
    if (apart[0] < least_apart_radii * largest_m - tiny_m)
        draw.refuse("apart_m", fmt::format("two discs of radius {:g} mm must be at least {:g} mm apart, {:g} radii", 1e3 * largest_m, 1e3 * least_apart_radii * largest_m, least_apart_radii));
    std::copy(apart.begin(), apart.end(), d.pair_apart_m);
}

}  // namespace

bool is_role_of_pairs(const std::string& role) { return is_role(role) && role != "validation" && role != "held_out" && role != "held_out_full"; }

void read_solid_place(TomlReader& draw, const Study& study, Study::Draws& d) {
    const Study::Geometry& g = study.geometry;
    const std::vector<double> tilt = draw.numbers("tilt_deg", 2, {0, 180}), clearance = draw.numbers("clearance_m", 2, positive);
    if (tilt[0] > tilt[1]) draw.refuse("tilt_deg", "must be [smallest, largest]");
    if (!(clearance[0] < clearance[1])) draw.refuse("clearance_m", "must be [smallest, largest], not the same");
    const double largest_m = d.radii_m.empty() ? study.indenter.radius_m : *std::max_element(d.radii_m.begin(), d.radii_m.end());
    if (clearance[0] < study.indenter.clearance_m(largest_m) - tiny_m)
        draw.refuse("clearance_m", fmt::format("a disc of radius {:g} mm needs {:g} mm {}", 1e3 * largest_m, 1e3 * study.indenter.clearance_m(largest_m),
                                               g.is_block() ? "from every wall" : "to where the surface ends or turns"));
    if (g.is_block() && !(clearance[0] < std::min(g.width_m, g.length_m) / 2))
        draw.refuse("clearance_m", fmt::format("no place of the {:g} x {:g} m top has this distance from every wall", g.width_m, g.length_m));
    std::copy(tilt.begin(), tilt.end(), d.tilt_deg);
    std::copy(clearance.begin(), clearance.end(), d.clearance_m);
}

void read_solid_draws(TomlReader in, Study& study) {
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
        d.radii_m = read_radii(draw, study);
        read_solid_place(draw, study, d);
        if (draw.has("apart_m")) read_pairs(draw, study, d);
        add_draws(draw, d, study);
    }
    in.refuse_the_rest();
}

void read_solid_fe(TomlReader& in, Study& study) {
    TomlReader indenter = in.table("indenter");
    study.indenter.kind = indenter.text("kind");
    if (study.indenter.kind != "disc") indenter.refuse("kind", "'" + study.indenter.kind + "' is only for the plane; a solid " + (study.geometry.is_block() ? "block" : "shape") + " needs disc");
    study.indenter.radius_m = indenter.number("radius_m", positive);
    indenter.refuse_the_rest();

    TomlReader mesh = in.table("mesh");
    for (const char* key : {"refine", "check_refine"})
        if (mesh.has(key)) mesh.refuse(key, fmt::format("is only for the plane; a solid {} has sizes_m and check_sizes_m", study.geometry.is_block() ? "block" : "shape"));
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
        if (loads.has(key))
            loads.refuse(key, study.geometry.is_block() ? "is only for the plane; a solid block has contacts"
                                                        : "is only for the plane; a solid shape has contacts or spread");
    study.loads = read_magnitudes(loads, study.geometry);
    if (study.geometry.is_block())
        study.loads.paths = read_contacts(loads, study);
    else
        read_shape_contacts(loads, study);
    loads.refuse_the_rest();

    if (in.has("map")) {
        if (!study.nodule) in.refuse("map", "needs a nodule");
        study.map = read_map(in.table("map"), study);
    }
}

}  // namespace tissue
