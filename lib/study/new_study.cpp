#include "study/new_study.h"

#include <Eigen/Core>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "error.h"
#include "mesh/fixed_region.h"
#include "mesh/surface.h"
#include "study/shape_extent.h"
#include "surface_file/surface_file.h"
#include "surface_file/vtk_file.h"

namespace tissue {
namespace {

// Range of a tissue's size: least shortest side in the plane and in space, largest longest side. Outside of it the unit
// of length is most likely wrong.
constexpr double smallest_m = 0.01, smallest_solid_m = 0.016, largest_m = 2;

/// The largest number not above x that is 1, 1.5, 2, 2.5, 3, 4, 5, 6 or 8 times a power of ten.
double round_down(double x) {
    const double power = std::pow(10, std::floor(std::log10(x)));
    double best = power;
    for (const double digit : {1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0})
        if (digit * power <= x * (1 + 1e-9)) best = digit * power;
    return best;
}

/// Short form of a number: 0.0025, not 0.0025000000000000001.
std::string text(double x) { return fmt::format("{:.12g}", x); }

std::string quoted(const std::string& name) {
    std::string safe;
    for (const char c : name) safe += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
    return '"' + safe + '"';
}

std::string list(const std::vector<std::string>& names) {
    std::vector<std::string> all;
    for (const std::string& name : names) all.push_back(quoted(name));
    return fmt::format("[{}]", fmt::join(all, ", "));
}

/// Sides of a tissue's bounding box [m].
struct Size {
    double longest, shortest, mean;  ///< mean: geometric
};

/// Size of the tissue. Where the file does not give it, it is estimated from the length of the springs: the longest
/// side is ten springs.
Size size_of(const ShapeExtent& shape, const NewStudy& wanted) {
    if (!shape.low) {
        if (!wanted.size_m)
            throw MismatchError(wanted.shape + ": its size is unknown before gmsh meshes it; give the length of the springs [m] as --size, a tenth of the tissue's length");
        return {10 * *wanted.size_m, 6 * *wanted.size_m, 8 * *wanted.size_m};
    }
    const int dimensions = shape.solid ? 3 : 2;
    Size size{0, std::numeric_limits<double>::infinity(), 1};
    for (int i = 0; i < dimensions; ++i) {
        const double side = ((*shape.high)[static_cast<std::size_t>(i)] - (*shape.low)[static_cast<std::size_t>(i)]) * wanted.unit_m;
        size.longest = std::max(size.longest, side);
        size.shortest = std::min(size.shortest, side);
        size.mean *= std::pow(side, 1.0 / dimensions);
    }
    if (!(size.longest <= largest_m))
        throw MismatchError(fmt::format("{}: is {:.3g} m long; is this in millimetres? give its unit as --unit mm, cm, m or inch", wanted.shape, size.longest));
    // in space the least is larger, because a disc keeps at least 5 mm from where the surface turns
    if (const double least_m = shape.solid ? smallest_solid_m : smallest_m; !(size.shortest >= least_m))
        throw MismatchError(fmt::format("{}: is {:.3g} mm wide, and at least {:g} mm are needed; give its unit as --unit mm, cm, m or inch", wanted.shape,
                                        1e3 * size.shortest, 1e3 * least_m));
    return size;
}

/// Whether a name is "surface-1", "surface-2", ...
bool is_part_name(const std::string& name) {
    constexpr std::string_view begin = "surface-";
    return name.size() > begin.size() && name.compare(0, begin.size(), begin) == 0 && name[begin.size()] != '0' &&
           name.find_first_not_of("0123456789", begin.size()) == std::string::npos;
}

void check_held(const ShapeExtent& shape, const NewStudy& wanted) {
    const std::string what = shape.solid ? "surface" : "curve";
    const bool unnamed_stl = shape.boundaries.empty() && is_surface_file(wanted.shape);
    const std::string there = !shape.boundaries.empty() ? fmt::format("its names: {}", fmt::join(shape.boundaries, ", "))
                              : unnamed_stl ? "it has no names: parts between edges that turn by more than 40 degrees are surface-1 (the largest), surface-2, ..."
                                            : fmt::format("it has no names: name its physical {}s in gmsh", what);
    if (wanted.fixed.empty()) throw MismatchError(fmt::format("{}: --held must name the {}s that are fixed; {}{}", wanted.shape, what, there, shape.solid ? "; or give a region in m: --held 'below z = 0.01'" : ""));
    for (const std::string& name : wanted.fixed)
        if (const auto other = FixedRegion::within(name)) refuse_vtk(other->file);
    std::vector<std::string> names;
    for (const std::string& name : wanted.fixed) {
        if (shape.solid && FixedRegion::of(name, read_other_surface, wanted.unit_m)) continue;
        names.push_back(name);
        const bool may_be = unnamed_stl ? is_part_name(name) : std::find(shape.boundaries.begin(), shape.boundaries.end(), name) != shape.boundaries.end();
        if (!may_be && !unnamed_stl) throw MismatchError(fmt::format("{}: has no {} '{}' to fix; {}", wanted.shape, what, name, there));
    }
    // make_surface refuses a number larger than that of the parts
    if (unnamed_stl && !names.empty()) make_surface(read_surface_file(wanted.shape), names, wanted.unit_m);
}

/// Refuses a fixed region that contains nothing or all of the tissue's bounding box. Without this check the error would
/// only appear during meshing.
void check_regions(const ShapeExtent& shape, const NewStudy& wanted) {
    // arcs of a .geo may extend beyond the box of its points
    const bool points_alone = std::filesystem::path(wanted.shape).extension() == ".geo";
    if (!shape.low || !shape.solid || points_alone) return;
    constexpr int along = 20;
    const Eigen::Vector3d low = wanted.unit_m * Eigen::Vector3d(shape.low->data()), high = wanted.unit_m * Eigen::Vector3d(shape.high->data());
    const double near_m = (high - low).norm() / along / 2;  // largest distance of a point of the box from a sample
    for (const std::string& name : wanted.fixed) {
        const auto region = FixedRegion::of(name, read_other_surface, wanted.unit_m);
        if (!region) continue;
        double least_m = std::numeric_limits<double>::infinity(), most_m = -least_m;
        for (int i = 0; i < (along + 1) * (along + 1) * (along + 1); ++i) {
            const Eigen::Array3d part = Eigen::Array3d(i % (along + 1), i / (along + 1) % (along + 1), i / (along + 1) / (along + 1)) / along;
            const double out_m = region->outside_m(low + (part * (high - low).array()).matrix());
            least_m = std::min(least_m, out_m);
            most_m = std::max(most_m, out_m);
        }
        if (least_m > near_m || most_m <= 0)
            throw MismatchError(fmt::format("{}: '{}' fixes {} of it; in metres it extends from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g})", wanted.shape, region->text(),
                                            most_m <= 0 ? "all" : "nothing", low[0], low[1], low[2], high[0], high[1], high[2]));
    }
}

/// Length of the springs [m]. In the plane the springs of a .msh are its edges; their length is estimated from the
/// number of its nodes. In space springs have a lattice of their own.
double spring_length(const ShapeExtent& shape, const NewStudy& wanted, const Size& size) {
    constexpr double filled = 0.7;  // estimated part of the bounding box that is tissue
    if (shape.nodes > 0 && !shape.solid) return size.mean * std::sqrt(filled / static_cast<double>(shape.nodes));
    if (wanted.size_m) return *wanted.size_m;
    return round_down(shape.solid ? std::min(size.mean / 8, size.shortest / 3) : size.mean / 8);
}

std::string head(const ShapeExtent& shape, const NewStudy& wanted) {
    const std::string regions = shape.regions.size() < 2 ? ""
        : fmt::format("# The shape's named {}: {}. A table after [material] gives one its own material, of the same law:\n"
                      "#   [material.regions.NAME]\n#   C1_Pa = 3000.0\n",
                      shape.solid ? "volumes" : "surfaces", fmt::join(shape.regions, ", "));
    return fmt::format("# Written by tissuectl new. All units are SI and part of the keys' names; results/FORMATS.md lists all keys.\n{}\n[geometry]\n{}"
                       "shape = {}    # relative to this file\n{}unit_m = {}    # m, unit of length of that file\n"
                       "fixed = {}    # its named {} that are fixed{}; the rest is free\n{}{}\n",
                       regions, shape.solid ? "solid = true    # in space\n" : "", quoted(wanted.shape_in_study), wanted.trust_geo ? "trust_geo = true    # gmsh runs it as a program\n" : "",
                       text(wanted.unit_m), list(wanted.fixed_in_study.empty() ? wanted.fixed : wanted.fixed_in_study), shape.solid ? "surfaces" : "curves", shape.solid ? ", or regions, in m" : "",
                       wanted.bed_Pa_m > 0 ? fmt::format("bed_Pa_m = {}    # Pa/m, stiffness per area of the elastic bed under the fixed parts; without it they do not move\n", text(wanted.bed_Pa_m)) : "",
                       shape.solid ? "" : fmt::format("thickness_m = {}    # m, thickness of the slice; forces are proportional to it\n", text(wanted.thickness_m)));
}

std::string lattice(const ShapeExtent& shape, double spring_m) {
    return shape.nodes > 0 ? "" : fmt::format("[lattice]\nsize_m = {}    # m, {}\n\n", text(spring_m), shape.solid ? "edge length of the facets of its surface" : "length of the springs");
}

std::string material(const ShapeExtent& shape, const NewStudy& wanted) {
    return fmt::format("[material]\npreset = \"{}\"    # fem/materials/{}.toml: material law, Pa, kg/m3 and their source; or instead\n"
                       "# law = \"mooney-rivlin\"    # with C1_Pa, C2_Pa; \"neo-Hookean\" with C1_Pa; \"ogden\" with mu_Pa, alpha; and density_kg_m3\n{}\n",
                       wanted.preset, wanted.preset, shape.solid ? "" : "formulation = \"plane-strain\"    # or \"plane-stress\"\n");
}

constexpr const char* solver = "[solver]\ntolerance = 1e-9    # largest force on a free node over the largest reaction\nmax_newton = 12    # iterations before a load step is halved\n\n";
constexpr const char* training = "[training]\nforce_scale = 0.01    # relative force error with the same weight as\nshape_scale = 0.03    # this relative displacement error\n";

WrittenStudy plane_study(const ShapeExtent& shape, const NewStudy& wanted, const Size& size, double spring_m) {
    constexpr double widest_m = 0.005;
    const double half_width_m = std::min(widest_m, round_down(spring_m / 2));
    const int refine = std::max(2, static_cast<int>(std::ceil(spring_m / half_width_m - 1e-3)));
    const double depth_m = 3 * round_down(size.shortest / 30), step_m = depth_m / 3;
    const double spacing_m = round_down((size.longest + size.shortest) / 8);
    std::string toml = head(shape, wanted) + lattice(shape, spring_m) + material(shape, wanted);
    toml += fmt::format("[mesh]\nrefine = {}    # finite elements along a spring\n\n"
                        "[indenter]\nkind = \"patch\"\nhalf_width_m = {}    # m, along the boundary\n\n",
                        refine, text(half_width_m));
    toml += solver;
    toml += fmt::format("[loads]\nmagnitudes_m = [{}, {}, {}]    # m, tool displacements of the load cases\nrecord_step_m = {}    # m\n\n"
                        "[loads.sweep]    # training contacts along the free outline\nspacing_m = {}    # m\nclearance_m = {}    # m, from the fixed curve\n"
                        "angles_deg = [-20, 0, 20]    # degrees off the inward normal\n\n",
                        text(step_m), text(2 * step_m), text(depth_m), text(step_m), text(spacing_m), text(3 * half_width_m));
    const auto draw = [&](const char* role, const char* what, int seed, int count) {
        return fmt::format("[draws.{}]    # {}\nseed = {}\ncount = {}\ndepth_m = [{}, {}]    # m\nmax_angle_deg = 20    # degrees\n\n", role, what, seed, count,
                           text(step_m), text(depth_m));
    };
    toml += draw("validation", "contacts of the validation set", 1, 10) + draw("held_out", "contacts of the test set", 2, 40);
    toml += "[springs]\ntopology = \"edges\"    # of the triangles\nstiffness = \"law\"    # an energy model; terms: lib/springs/energy_model_terms.h\nterms = [\n"
            "  \"spring.all\", \"spring.held\", \"spring.upright.held\", \"contact.normal\", \"contact.tangent\", \"contact.rotation\", \"contact.stretch\",\n]\n\n";
    toml += training;
    return {toml, false, {fmt::format("tool: a patch {} mm wide (indenter.half_width_m), displaced by up to {} mm (loads.magnitudes_m)", text(2e3 * half_width_m), text(1e3 * depth_m)),
                   fmt::format("training contacts every {} mm (loads.sweep.spacing_m), at -20, 0 and 20 degrees", text(1e3 * spacing_m))}};
}

WrittenStudy solid_study(const ShapeExtent& shape, const NewStudy& wanted, const Size& size, double spring_m) {
    constexpr double widest_m = 0.007, margin_m = 0.006;
    constexpr int contacts = 12;
    const double radius_m = std::min(widest_m, round_down(0.7 * spring_m));
    const double depth_m = 2 * round_down(size.shortest / 16), clearance_m = radius_m + margin_m;
    std::string toml = head(shape, wanted) + lattice(shape, spring_m) + material(shape, wanted);
    toml += fmt::format("[mesh]    # each load path has its own mesh\nsizes_m = [{}, {}]    # m, of finite elements at the tool and far away\ncheck_fraction = 0\n\n"
                        "[indenter]\nkind = \"disc\"\nradius_m = {}    # m\n\n",
                        text(round_down(3 * radius_m / 7)), text(round_down(1.2 * spring_m)), text(radius_m));
    toml += solver;
    toml += fmt::format("[loads]\nmagnitudes_m = [{}, {}]    # m, tool displacements of the load cases\nrecord_step_m = {}    # m\n\n"
                        "[loads.spread]    # training contacts, as far from each other as possible\ncount = {}\n"
                        "clearance_m = {}    # m, from where the free surface ends or turns\npushes_deg = [[0, 0], [30, 0]]    # degrees: tilt off the inward normal, azimuth\n\n",
                        text(depth_m / 2), text(depth_m), text(depth_m / 4), contacts, text(clearance_m));
    const auto draw = [&](const char* role, const char* what, int seed, int count) {
        return fmt::format("[draws.{}]    # {}\nseed = {}\ncount = {}\ndepth_m = [{}, {}]    # m\ntilt_deg = [0, 30]    # degrees\nclearance_m = [{}, {}]    # m\n\n", role, what,
                           seed, count, text(depth_m / 4), text(depth_m), text(clearance_m), text(std::max(size.longest, 2 * clearance_m)));
    };
    toml += draw("validation", "contacts of the validation set", 1, 10) + draw("held_out", "contacts of the test set", 2, 20);
    toml += fmt::format("[springs]\ntopology = \"embedded\"    # in cubes, with springs along their edges and diagonals\nspacing_m = {}    # m, edge of a cube\n"
                        "stiffness = \"law\"    # an energy model; terms: lib/springs/energy_model_terms.h\n", text(spring_m));
    toml += "terms = [\n"
            "  \"spring.all\", \"spring.face\", \"spring.body\", \"cell.all\", \"support.all\", \"contact.normal\", \"contact.tangent\", \"contact.imprint_normal\", \"contact.imprint_tangent\",\n"
            "  \"contact.softening\", \"contact.coupling\", \"contact.normal.curved\", \"contact.tangent.curved\", \"contact.imprint_normal.curved\", \"contact.imprint_tangent.curved\",\n"
            "  \"skin.normal\", \"skin.tangent\", \"skin.heave\", \"skin.radial\",\n]\n\n";
    toml += training;
    return {toml, true, {fmt::format("tool: a disc of radius {} mm (indenter.radius_m), displaced by up to {} mm (loads.magnitudes_m)", text(1e3 * radius_m), text(1e3 * depth_m)),
                   fmt::format("{} training contacts over the free surface (loads.spread), along the normal and at 30 degrees", contacts)}};
}

}  // namespace

WrittenStudy new_study(const NewStudy& wanted) {
    const ShapeExtent shape = shape_extent(wanted.shape);
    if (shape.fault)
        throw MismatchError(fmt::format("{}: cannot be filled: {}; `tissuectl surface` reports all faults, and with --repair OUT.stl writes a surface without them", wanted.shape, fault_text(*shape.fault, " mm", 1e3 * wanted.unit_m)));
    check_held(shape, wanted);
    if (wanted.bed_Pa_m > 0 && !shape.solid) throw MismatchError(wanted.shape + ": --bed needs a tissue in space; in the plane the fixed part does not move");
    const Size size = size_of(shape, wanted);
    check_regions(shape, wanted);
    if (wanted.size_m && shape.low) {
        constexpr double most_along = 100;
        if (*wanted.size_m > size.shortest / 2)
            throw MismatchError(fmt::format("{}: --size {:g} m is more than half of its shortest side, {:.3g} mm", wanted.shape, *wanted.size_m, 1e3 * size.shortest));
        if (*wanted.size_m < size.longest / most_along)
            throw MismatchError(fmt::format("{}: --size {:g} m is less than a hundredth of its longest side, {:.3g} mm: this makes too many springs", wanted.shape, *wanted.size_m, 1e3 * size.longest));
        constexpr double most_cubes = 1e5;  // as in cases/shape_checks.h
        if (const double cubes = std::pow(size.mean / *wanted.size_m, 3); shape.solid && cubes > most_cubes)
            throw MismatchError(fmt::format("{}: --size {:g} m makes {:.2g} cubes, at most {:g} are possible", wanted.shape, *wanted.size_m, cubes, most_cubes));
    }
    const double spring_m = spring_length(shape, wanted, size);
    WrittenStudy study = (shape.solid ? solid_study : plane_study)(shape, wanted, size, spring_m);
    std::vector<std::string> sides;
    for (std::size_t i = 0; shape.low && i < (shape.solid ? 3 : 2); ++i)
        sides.push_back(fmt::format("{:.3g}", 1e3 * wanted.unit_m * ((*shape.high)[i] - (*shape.low)[i])));
    const std::string how_large = sides.empty() ? "of a size that is unknown before meshing" : fmt::format("{} mm", fmt::join(sides, " x "));
    study.choices.insert(study.choices.begin(),
                         {fmt::format("{}: {}, {}; fixed: {}{}", wanted.shape, shape.solid ? "in space" : "in the plane", how_large, fmt::join(wanted.fixed, ", "),
                                      wanted.bed_Pa_m > 0 ? fmt::format(", on a bed of {} Pa/m", text(wanted.bed_Pa_m)) : ""),
                          shape.solid     ? fmt::format("springs in cubes of {} mm (springs.spacing_m){}", text(1e3 * spring_m),
                                                        wanted.size_m ? "" : ", the smaller of an eighth of its mean size and a third of its shortest side")
                          : shape.nodes > 0 ? fmt::format("springs: the edges of its {} nodes' mesh, about {:.2g} mm long", shape.nodes, 1e3 * spring_m)
                                            : fmt::format("springs {} mm long (lattice.size_m){}", text(1e3 * spring_m), wanted.size_m ? "" : ", an eighth of its mean size")});
    return study;
}

}  // namespace tissue
