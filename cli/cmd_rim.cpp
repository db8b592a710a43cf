#include <fmt/format.h>

#include <iostream>
#include <optional>

#include "command.h"
#include "error.h"
#include "io/atomic_file.h"
#include "mesh/disc_rim.h"
#include "mesh/inclusion.h"
#include "mesh/region_lookup.h"
#include "study/bed.h"
#include "surface_file/surface_file.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string mesh, named, out, filled, nodule;
    std::vector<std::string> fixed{"fixed"}, regions;
    std::vector<int> beds;
    std::vector<double> contact_m;
    double unit_m = 1, radius_m = 0.007, near_m = 0.003, far_m = 0.015;
};

/// Calls `make`; a MismatchError gets the file's name.
template <class Make>
auto about(const std::string& file, Make&& make) try {
    return make();
} catch (const MismatchError& e) {
    throw MismatchError(file + ": " + e.what());
}

void run(const Options& o) {
    if (!o.filled.empty()) {
        const MshFile mesh = read_msh(o.mesh, true, o.named);
        return write_file(o.out, to_msh(read_msh(o.filled, true), RegionLookup(mesh, o.regions, o.unit_m)));
    }
    if (o.contact_m.empty()) throw CLI::RequiredError("--contact");
    const std::string& named = o.named.empty() ? o.mesh : o.named;
    const Surface surface = make_surface(read_surface_or_msh(o.mesh, o.named), o.fixed, o.unit_m, read_other_surface, o.beds);
    const RimmedSurface made = about(named, [&] { return with_rim(surface, {{o.contact_m[0], o.contact_m[1], o.contact_m[2]}, o.radius_m, o.near_m, o.far_m}); });
    std::optional<Surface> nodule;
    if (!o.nodule.empty()) {
        nodule = about(o.nodule, [&] { return inclusion_facets(inclusion_surface(read_surface_file(o.nodule), o.unit_m), o.far_m); });
        const Inclusion tissue(made.surface);
        for (const auto& place : nodule->nodes.rowwise())
            if (!tissue.contains(place.transpose())) throw MismatchError(fmt::format("{}: its point ({:.6g}, {:.6g}, {:.6g}) m is not inside {}", o.nodule, place[0], place[1], place[2], named));
    }
    write_file(o.out, to_msh(made.surface, nodule ? &*nodule : nullptr));
    const Eigen::Vector3d& c = made.contact_m;
    std::cout << fmt::format("-contact_x {} -contact_y {} -contact_z {}\n", c.x(), c.y(), c.z());
}

}  // namespace

void add_rim(CLI::App& app, const Invocation&) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("rim", "Remesh a solid's surface around a disc, and print the contact on the surface.");
    command->add_option("--mesh", o->mesh, "the shape as gmsh saved it, MSH 2.2, or a surface: .stl, .obj, .ply, .off, .glb")->required()->type_name("FILE");
    command->add_option("--named", o->named, "name of the shape in messages (default: --mesh)")->type_name("FILE");
    command->add_option("--fixed", o->fixed, "fixed surfaces or regions (below_z_0.01, within_0.003_of_FILE)")->delimiter(',')->type_name("NAME,..")->capture_default_str();
    command->add_option("--beds", o->beds, "elastic bed under each of them, from 1, labelled 21, 22, ..; 0: none")->delimiter(',')->type_name("BED,..")->check(CLI::Range(0, static_cast<int>(most_beds)));
    command->add_option("--unit", o->unit_m, "the mesh's unit of length")->type_name("m")->capture_default_str();
    command->add_option("--contact", o->contact_m, "centre of the disc")->expected(3)->type_name("m m m");
    command->add_option("--radius", o->radius_m, "radius of the disc")->type_name("m")->capture_default_str();
    command->add_option("--size-near,--size_near", o->near_m, "length of triangle edges near the disc")->type_name("m")->capture_default_str();
    command->add_option("--size-far,--size_far", o->far_m, "length of triangle edges far from the disc")->type_name("m")->capture_default_str();
    CLI::Option* nodule = command->add_option("--nodule", o->nodule, "a closed surface inside the shape, in the same unit, which faces of elements must follow: written too")->type_name("FILE");
    CLI::Option* regions = command->add_option("--regions", o->regions, "volumes of the shape with a material of their own")->delimiter(',')->type_name("NAME,..");
    command->add_option("--filled", o->filled, "the surface filled with tetrahedra: label these by --regions instead of remeshing")->needs(regions)->excludes(nodule)->type_name("FILE");
    command->add_option("--out", o->out, "surface to write, with labels: fixed 1, free 2, disc 3, on beds 21, ..")->required()->type_name("FILE");
    command->callback([o] { run(*o); });
}

}  // namespace tissue::cli
