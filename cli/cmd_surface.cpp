#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "command.h"
#include "error.h"
#include "io/atomic_file.h"
#include "mesh/surface_repair.h"
#include "mesh/surface_report.h"
#include "surface_file/surface_file.h"
#include "surface_file/vtk_file.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string file, unit = "m", out;
    double closes_m = 0, offset_m = 0;
    bool json = false;
};

struct Unit {
    double m, mm;  ///< one unit in metres and in millimetres
};

nlohmann::json json_of(const SurfaceReport& r, const std::string& file, const Unit& unit) {
    const auto place = [](const Eigen::Vector3d& x) { return nlohmann::json{x.x(), x.y(), x.z()}; };
    nlohmann::json faults = nlohmann::json::object();
    for (const SurfaceFault& fault : r.faults) {
        nlohmann::json at = nlohmann::json::array();
        for (const Eigen::Vector3d& x : fault.first) at.push_back(place(x));
        faults[fault_name(fault.kind)] = {{"count", fault.count}, {"first", at}};
        if (fault.largest > 0) faults[fault_name(fault.kind)]["largest_m"] = unit.m * fault.largest;
    }
    return {{"file", file},
            {"unit_m", unit.m},
            {"points", r.points},
            {"triangles", r.triangles},
            {"slivers", r.slivers},
            {"turned", r.turned},
            {"low", place(r.low)},
            {"high", place(r.high)},
            {"area_m2", unit.m * unit.m * r.area},
            {"volume_m3", unit.m * unit.m * unit.m * r.volume},
            {"shortest_edge_m", unit.m * r.shortest},
            {"mean_edge_m", unit.m * r.mean},
            {"faults", faults},
            {"usable", r.faults.empty()}};
}

void print(const SurfaceReport& r, const std::string& file, const Unit& unit) {
    const Eigen::Vector3d size_mm = unit.mm * (r.high - r.low);
    std::cout << fmt::format("{}: {} triangles, {} points, {:.4g} x {:.4g} x {:.4g} mm, {}\n", file, r.triangles, r.points, size_mm.x(), size_mm.y(), size_mm.z(),
                             r.volume > 0 ? fmt::format("{:.4g} ml", 1e6 * unit.m * unit.m * unit.m * r.volume) : "not closed");
    std::cout << fmt::format("  mean edge {:.3g} mm, shortest {:.3g} mm; triangles with an angle below {:g} degree: {}; triangles with inward normals, turned when the surface is filled: {}\n", unit.mm * r.mean, unit.mm * r.shortest, sliver_angle_deg, r.slivers,
                             r.turned);
    for (const SurfaceFault& fault : r.faults) std::cout << "  " << fault_text(fault, " mm", unit.mm) << '\n';
    std::cout << (r.faults.empty() ? "  it can be filled\n" : "  it cannot be filled without a repair\n");
}

void run(const Options& o) {
    const Unit unit{units_m.at(o.unit), 1e3 * units_m.at(o.unit)};
    refuse_vtk(o.file);
    const MshFile mesh = read_surface_file(o.file);
    const SurfaceReport report = report_on(mesh);
    if (o.out.empty()) {
        if (o.json) std::cout << json_of(report, o.file, unit).dump() << '\n';
        else print(report, o.file, unit);
        if (!report.faults.empty()) throw IncompleteResult(fmt::format("{}: {}; --repair OUT.stl writes a surface without faults", o.file, fault_text(report.faults.front(), " mm", unit.mm)));
        return;
    }
    if (o.out.size() < 5 || o.out.substr(o.out.size() - 4) != ".stl") throw MismatchError(o.out + ": the repaired surface is an .stl file: give a name that ends in .stl");
    std::error_code error;
    if (std::filesystem::equivalent(o.file, o.out, error)) throw MismatchError(o.out + ": is the input file; name another file for the repaired surface");
    SurfaceRepair repair = usual_repair(mesh);
    if (o.closes_m > 0) repair = {o.closes_m / unit.m, o.closes_m / unit.m / 20};
    if (o.offset_m > 0) repair.offset = o.offset_m / unit.m;
    RepairedSurface made = repaired(mesh, repair);
    made.mesh.file = o.out;
    const SurfaceReport after = report_on(made.mesh);
    write_file(o.out, to_stl(made.mesh));
    const RepairDistances& d = made.distances;
    if (o.json) {
        std::cout << nlohmann::json{{"given", json_of(report, o.file, unit)},
                                    {"repaired", json_of(after, o.out, unit)},
                                    {"closes_m", unit.m * repair.closes},
                                    {"offset_m", unit.m * repair.offset},
                                    {"outside_m", {{"median", unit.m * d.median}, {"most", unit.m * d.most}}},
                                    {"given_from_it_m", {{"median", unit.m * d.given_median}, {"most", unit.m * d.given_most}, {"at", {d.given_at.x(), d.given_at.y(), d.given_at.z()}}}},
                                    {"left_out", d.left_out}}
                         .dump()
                  << '\n';
    } else {
        print(report, o.file, unit);
        print(after, o.out, unit);
        std::cout << fmt::format("  wrapped around the input at {:.3g} mm, holes and gaps narrower than {:.3g} mm closed; distance from the input: median {:.3g} mm, largest {:.3g} mm\n", unit.mm * repair.offset, unit.mm * repair.closes,
                                 unit.mm * d.median, unit.mm * d.most);
        std::cout << fmt::format("  distance of {} from the repaired surface: median {:.3g} mm, largest {:.3g} mm, at ({:.6g}, {:.6g}, {:.6g}){}\n", o.file, unit.mm * d.given_median, unit.mm * d.given_most, d.given_at.x(),
                                 d.given_at.y(), d.given_at.z(), d.left_out > 0 ? fmt::format("; smaller parts left out: {}", d.left_out) : "");
    }
    if (!after.faults.empty()) throw IncompleteResult(fmt::format("{}: {}; give a larger --closes", o.out, fault_text(after.faults.front(), " mm", unit.mm)));
}

}  // namespace

void add_surface(CLI::App& app, const Invocation&) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("surface", "Check whether a surface can be filled with tissue, report its faults and their places, and repair it.");
    command->add_option("file", o->file, std::string("the surface: ") + surface_endings)->required()->type_name("FILE");
    add_unit_option(*command, o->unit);
    command->add_option("--repair", o->out, "write a closed surface without self-intersections around the input, in the same unit, without names of groups")->type_name("OUT.stl");
    command->add_option("--closes", o->closes_m, "holes, gaps and cavities narrower than this are closed; default: a fiftieth of the extent")->type_name("m")->check(is_positive())->needs("--repair");
    command->add_option("--offset", o->offset_m, "distance of the new surface outside the given one; default: a twentieth of --closes")->type_name("m")->check(is_positive())->needs("--repair");
    command->add_flag("--json", o->json, "print JSON");
    command->callback([o] { run(*o); });
}

}  // namespace tissue::cli
