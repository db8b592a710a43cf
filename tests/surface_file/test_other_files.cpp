#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>

#include "error.h"
#include "mesh/surface.h"
#include "surface_file/surface_file.h"
#include "surface_file/vtk_file.h"
#include "../refusal.h"
#include "../example.h"

namespace tissue {
namespace {

using Catch::Matchers::Contains;

// A box of 2 x 3 x 4 in each format. The bits of a corner's number are its coordinates. Sides: z = 0, z = 4, then the
// four vertical ones; normals out.
const std::string points = "0 0 0\n2 0 0\n0 3 0\n2 3 0\n0 0 4\n2 0 4\n0 3 4\n2 3 4\n";
constexpr int sides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

std::string lines(const std::string& before) {
    std::string text;
    for (std::size_t begin = 0; begin < points.size();) {
        const std::size_t end = points.find('\n', begin);
        text += before + points.substr(begin, end - begin) + "\n";
        begin = end + 1;
    }
    return text;
}

std::string obj_facet(int side, const std::string& behind = "") {
    std::string text = "f";
    for (int corner : sides[side]) text += " " + std::to_string(corner + 1) + behind;
    return text + "\n";
}

std::string obj() { return "# a box\nmtllib none.mtl\n" + lines("v ") + "vn 0 0 1\ng bed\n" + obj_facet(0) + "g top\nusemtl red\n" + obj_facet(1, "//1") + "g sides\ns off\n" + obj_facet(2, "/1/1") + obj_facet(3) + obj_facet(4) + obj_facet(5); }

std::string off() {
    std::string text = "OFF\n# a box\n8 6 0\n" + points;
    for (const auto& side : sides) {
        text += "4";
        for (int corner : side) text += " " + std::to_string(corner);
        text += "\n";
    }
    return text;
}

void put(std::string& bytes, const void* value, std::size_t size) { bytes.append(static_cast<const char*>(value), size); }

std::string ply(const std::string& format, const std::string& list = "uchar int", const std::string& real = "float") {
    std::string text = "ply\nformat " + format + " 1.0\nelement vertex 8\nproperty " + real + " x\nproperty " + real + " y\nproperty " + real + " z\nelement face 6\nproperty list " + list + " vertex_indices\nend_header\n";
    if (format == "ascii") {
        text += points;
        for (const auto& side : sides) {
            text += "4";
            for (int corner : side) text += " " + std::to_string(corner);
            text += "\n";
        }
        return text;
    }
    const auto add = [&](const auto& value) {
        std::string bytes;
        put(bytes, &value, 4);
        if (format == "binary_big_endian") std::reverse(bytes.begin(), bytes.end());
        text += bytes;
    };
    for (int n = 0; n < 8; ++n)
        for (const float x : {n & 1 ? 2.f : 0.f, n & 2 ? 3.f : 0.f, n & 4 ? 4.f : 0.f}) add(x);
    for (const auto& side : sides) {
        text += '\4';
        for (std::int32_t corner : side) add(corner);
    }
    return text;
}

/// With carriage returns as line ends.
std::string cr(std::string text) {
    std::replace(text.begin(), text.end(), '\n', '\r');
    return text;
}

/// The sides z = 0 and z = 4 and the walls are three nodes, rotated by 90 degrees about z and translated by (10, 0, 0).
std::string glb(std::string json = "") {
    std::string bytes;
    for (int n = 0; n < 8; ++n)
        for (const float x : {n & 1 ? 2.f : 0.f, n & 2 ? 3.f : 0.f, n & 4 ? 4.f : 0.f}) put(bytes, &x, 4);
    for (const auto& s : sides)
        for (const int k : {0, 1, 2, 0, 2, 3}) {
            const auto corner = static_cast<std::uint16_t>(s[k]);
            put(bytes, &corner, 2);
        }
    const auto accessor = [](int from, int count) { return R"({"bufferView":1,"byteOffset":)" + std::to_string(12 * from) + R"(,"componentType":5123,"type":"SCALAR","count":)" + std::to_string(6 * count) + "}"; };
    if (json.empty())
        json = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
            "nodes":[{"children":[1,2,3],"translation":[10,0,0],"rotation":[0,0,0.70710678118,0.70710678118]},{"mesh":0,"name":"bed"},{"mesh":1,"name":"top"},{"mesh":2}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]},{"primitives":[{"attributes":{"POSITION":0},"indices":2}]},{"name":"walls","primitives":[{"attributes":{"POSITION":0},"indices":3}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":8},)" +
               accessor(0, 1) + "," + accessor(1, 1) + "," + accessor(2, 4) + R"(],"bufferViews":[{"buffer":0,"byteLength":96},{"buffer":0,"byteOffset":96,"byteLength":72}],"buffers":[{"byteLength":168}]})";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string file = "glTF";
    const auto word = [&](std::size_t value) {
        const auto bits = static_cast<std::uint32_t>(value);
        put(file, &bits, 4);
    };
    word(2);
    word(12 + 8 + json.size() + 8 + bytes.size());
    word(json.size());
    file += "JSON" + json;
    word(bytes.size());
    file += std::string("BIN\0", 4) + bytes;
    return file;
}

struct Held {
    double held_m2 = 0, all_m2 = 0, volume_m3 = 0;
};
Held held(const MshFile& mesh, const std::string& name) {
    const Surface s = make_surface(mesh, {name}, 1);
    Held sum;
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
        const double area = (s.corner(t, 1) - s.corner(t, 0)).cross(s.corner(t, 2) - s.corner(t, 0)).norm() / 2;
        sum.all_m2 += area;
        if (s.label[static_cast<std::size_t>(t)] == Surface::fixed_label) sum.held_m2 += area;
        sum.volume_m3 += s.corner(t, 0).dot(s.corner(t, 1).cross(s.corner(t, 2))) / 6;
    }
    return sum;
}

}  // namespace

TEST_CASE("a box is read as the same surface from every format", "[surface_file]") {
    const TemporaryFolder folder;
    std::string negative = obj();
    for (std::size_t at; (at = negative.find("f 1 3 4 2\n")) != std::string::npos;) negative.replace(at, 10, "f -8 -6 -5 -7\n");
    for (const auto& [name, content] : std::map<std::string, std::string>{{"a.obj", obj()}, {"b.OBJ", negative}, {"c.off", off()}, {"d.off", "OFF 8 6 12\n" + off().substr(off().find("8 6 0") + 6)}, {"e.ply", ply("ascii")},
                                                                        {"f.ply", ply("binary_little_endian")}, {"g.ply", ply("ascii", "uint8 uint32", "double")}, {"i.ply", ply("ascii", "int uint", "double")}, {"j.ply", ply("binary_big_endian")}, {"k.obj", cr(obj())}, {"h.glb", glb()}}) {
        CAPTURE(name);
        REQUIRE(is_surface_file(name));
        const MshFile mesh = read_surface_file(folder.file(name, content));
        CHECK(mesh.points.size() == 8);
        CHECK(mesh.triangles.size() == 12);
        const bool named = name.find(".ply") == std::string::npos && name.find(".off") == std::string::npos;
        CHECK(mesh.triangle_names.size() == (named ? 3u : 0u));
        const Held box = held(mesh, named ? "bed" : "surface-5");
        CHECK(box.held_m2 == Approx(6).epsilon(1e-6));
        CHECK(box.all_m2 == Approx(52).epsilon(1e-6));
        CHECK(box.volume_m3 == Approx(24).epsilon(1e-6));
    }
    const MshFile moved = read_surface_file(folder.file("h.glb", glb()));
    CHECK(moved.triangle_names == std::map<int, std::string>{{1, "bed"}, {2, "top"}, {3, "walls"}});
    CHECK(moved.points.front().x == Approx(10).epsilon(1e-6));  // (0, 0, 0)
    double low = 1e9;
    for (const auto& p : moved.points) low = std::min(low, p.x);
    CHECK(low == Approx(7).epsilon(1e-6));  // (0, 3, 0) is rotated to (-3, 0, 0)
}

TEST_CASE("a group of an .obj may continue later; a single object gives no name; polygons are triangulated", "[surface_file]") {
    const TemporaryFolder folder;
    const std::string parts = lines("v ") + "o bed\n" + obj_facet(0) + "o rest\n" + obj_facet(1) + obj_facet(2) + "o bed\n" + obj_facet(3) + "o rest\n" + obj_facet(4) + obj_facet(5);
    CHECK(held(read_surface_file(folder.file("parts.obj", parts)), "bed").held_m2 == Approx(6 + 8));
    std::string alone = lines("v ") + "o liver\n";
    for (int s = 0; s < 6; ++s) alone += obj_facet(s);
    CHECK(read_surface_file(folder.file("alone.obj", alone)).triangle_names.empty());
    // a facet of six corners, not convex at one of them, is triangulated
    const std::string hook = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n";
    const MshFile mesh = read_surface_file(folder.file("hook.obj", hook));
    double area = 0;
    for (const auto& t : mesh.triangles) {
        const auto& a = mesh.points[static_cast<std::size_t>(t.node[0])];
        const auto& b = mesh.points[static_cast<std::size_t>(t.node[1])];
        const auto& c = mesh.points[static_cast<std::size_t>(t.node[2])];
        const double twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        CHECK(twice > 0);
        area += twice / 2;
    }
    CHECK(mesh.triangles.size() == 4);
    CHECK(area == Approx(3));
    // a triangle as a quadrilateral with a repeated corner
    for (const char* facet : {"f 1 2 3 3", "f 1 2 2 3", "f 1 1 2 3", "f 1 2 3 1"}) CHECK(read_surface_file(folder.file("three.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\n") + facet + "\n")).triangles.size() == 1);
    // groups of one name in two objects, and names with a #
    std::string objects = lines("v ") + "o bed\ng mat\n" + obj_facet(0) + "o rest\ng mat\n" + obj_facet(1) + "g part #1\n" + obj_facet(2) + obj_facet(3) + "g part #2\n" + obj_facet(4) + obj_facet(5) + "# end\n";
    CHECK(read_surface_file(folder.file("objects.obj", objects)).triangle_names == std::map<int, std::string>{{1, "bed/mat"}, {2, "rest/mat"}, {3, "part #1"}, {4, "part #2"}});
}

TEST_CASE("a mirrored node of a .glb keeps outward normals", "[surface_file]") {
    const TemporaryFolder folder;
    std::string json = glb().substr(20, glb().find("BIN") - 24);
    const std::string from = "\"translation\":[10,0,0]";
    REQUIRE(json.find(from) != std::string::npos);
    json.replace(json.find(from), from.size(), "\"scale\":[1,1,-1]");
    const MshFile mesh = read_surface_file(folder.file("mirrored.glb", glb(json)));
    double six = 0;
    for (const auto& t : mesh.triangles) {
        const auto& a = mesh.points[static_cast<std::size_t>(t.node[0])];
        const auto& b = mesh.points[static_cast<std::size_t>(t.node[1])];
        const auto& c = mesh.points[static_cast<std::size_t>(t.node[2])];
        six += a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x);
    }
    CHECK(six == Approx(6 * 24).epsilon(1e-5));
}

TEST_CASE("a VTK file is refused with the name of the program that converts it", "[surface_file]") {
    CHECK(vtk_refusal("a/organ.vtp") == "a/organ.vtp: is a VTK surface; convert it first: scripts/vtk_surface a/organ.vtp a/organ.obj");
    CHECK(vtk_refusal("ORGAN.VTK") == "ORGAN.VTK: is a VTK surface; convert it first: scripts/vtk_surface ORGAN.VTK ORGAN.obj");
    CHECK_THAT(refusal<FileError>([] { refuse_vtk("organ.vTu"); }), Contains("organ.vTu: is an unstructured grid") && Contains("scripts/vtk_surface organ.vtp organ.obj; or give its tetrahedra as a .msh"));
    for (const char* other : {"organ.obj", "vtp", ".vtp", "organ.vtp.obj", "organvtp", ""}) {
        CHECK(vtk_refusal(other).empty());
        CHECK_NOTHROW(refuse_vtk(other));
    }
}

TEST_CASE("a damaged surface file is refused with file, place and cause", "[surface_file]") {
    const TemporaryFolder folder;
    const auto said = [&](const std::string& name, const std::string& content) { return refusal<FileError>([&] { read_surface_file(folder.file(name, content)); }); };
    CHECK_THAT(said("a.obj", "v 0 0\n"), Contains("a.obj:1: is not 'v x y z'"));
    CHECK_THAT(said("a.obj", "v 0 0 1,5\n"), Contains("a.obj:1: is not 'v x y z'"));
    CHECK_THAT(said("a.obj", "v 0 0 nan\n"), Contains("a.obj:1: has a coordinate that is not a finite number"));
    CHECK_THAT(said("a.obj", "v 0 0 0\nf 0 1 1\n"), Contains("a.obj:2: names point 0 of 1"));
    CHECK_THAT(said("a.obj", "v 0 0 0\nf 1 1 -2\n"), Contains("a.obj:2: names point -2 of 1"));
    CHECK_THAT(said("a.obj", "v 0 0 0\nf 1 1 2\n"), Contains("a.obj:2: names a point that the file does not have; it has 1"));
    CHECK_THAT(said("a.obj", "v 0 0 0\nf 1 1\n"), Contains("a.obj:2: is not 'f i j k ..'"));
    CHECK_THAT(said("a.obj", "v 0 0 0\nf 1 1 1 \\\n1\n"), Contains("a.obj:2: is not 'f i j k ..'"));
    std::string many = "v 0 0 0\nf";
    for (int k = 0; k < 256; ++k) many += " 1";
    CHECK_THAT(said("a.obj", many + "\n"), Contains("a.obj:2: has 256 corners; a facet must have 3 to 255"));
    CHECK_THAT(said("a.obj", "SystemCall \"rm\";\n"), Contains("a.obj: has no facets"));
    CHECK_THAT(said("a.off", "8 6 0\n"), Contains("a.off:1: is not 'OFF'"));
    CHECK_THAT(said("a.off", "OFF BINARY\n"), Contains("a.off:1: is a binary .off"));
    CHECK_THAT(said("a.off", "OFF\n1000000000000 1 0\n0 0 0\n"), Contains("a.off: is truncated: 'x y z' is missing"));
    CHECK_THAT(said("a.off", "OFF\n1 1 0\n0 0 0\n1000000000 0 0 0\n"), Contains("a.off:4: is a facet of 1000000000 corners"));
    CHECK_THAT(said("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0\n"), Contains("a.off:4: is not 'COUNT i j k ..'"));
    CHECK_THAT(said("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 -1\n"), Contains("a.off:4: names a point that the file does not have"));
    CHECK_THAT(said("a.off", "OFF\n2 1 0\n0 0 0 1 1 1\n3 0 0 1\n"), Contains("a.off:3: has more than 'x y z'; a file with colours must begin with COFF"));
    CHECK_THAT(said("a.ply", "pl\n"), Contains("a.ply:1: is not a .ply"));
    CHECK_THAT(said("a.ply", ply("ascii", "uchar int", "int64")), Contains("a.ply:4: 'int64' is not a number type of .ply"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar float x\nproperty float x\n"), Contains("a.ply:5: a second property 'x'"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty list char int vertex_indices\nend_header\n-1\n"), Contains("a.ply: face 1 has a list 'vertex_indices' of length -1"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nelement vertex 190000\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n"), Contains("element 'vertex' has no properties"));
    CHECK_THAT(said("a.ply", ply("binary_little_endian").substr(0, 300)), Contains("a.ply: is truncated within an element, 131 bytes after its header"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000\n"), Contains("a.ply:3: has 4000000000 elements"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n"), Contains("a.ply: has points and no facets"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nproperty float x\n"), Contains("a.ply:3: is a property without an element"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nelemen vertex 8\n"), Contains("a.ply:3: is not a line of a .ply header"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nproperty list uchar int vertex_index\nend_header\n"), Contains("must have one list"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nelement vertices 1\n"), Contains("a.ply:4: a second element 'vertices'"));
    CHECK_THAT(said("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar float vertex_indices\nend_header\n0 0 0\n3 0 0 0.9\n"),
               Contains("a.ply:11: names a point that the file does not have"));
    CHECK_THAT(said("a.glb", glb("{\"asset\":{}}")), Contains("a.glb: has no scene"));
    std::string wrong = ply("ascii");
    wrong.replace(wrong.rfind("4 1 3"), 5, "4 1 8");
    CHECK_THAT(said("a.ply", wrong), Contains("a.ply:23: names a point that the file does not have; it has 8"));
    const std::string good = glb();
    CHECK_THAT(said("a.glb", good.substr(0, 40)), Contains("a.glb: is not a .glb: "));
    CHECK_THAT(said("a.glb", "glTF"), Contains("a.glb: is not a .glb: "));
    const auto changed = [&](const std::string& from, const std::string& to) {
        std::string json = good.substr(20, good.find("BIN") - 24);
        REQUIRE(json.find(from) != std::string::npos);
        return glb(json.replace(json.find(from), from.size(), to));
    };
    CHECK_THAT(said("a.glb", changed("\"count\":8", "\"count\":9")), Contains("a.glb: mesh '': its data extend beyond their part of the file, of 96 bytes"));
    CHECK_THAT(said("a.glb", changed("\"count\":24", "\"count\":25")), Contains("beyond their part of the file, of 72 bytes"));
    CHECK_THAT(said("a.glb", changed("\"children\":[1,2,3]", "\"children\":[0]")), Contains("a.glb: node 0 is reached twice; a scene must be a tree"));
    CHECK_THAT(said("a.glb", changed("\"mesh\":2", "\"mesh\":7")), Contains("a.glb: has no meshes 7"));
    CHECK_THAT(said("a.glb", changed("\"componentType\":5126", "\"componentType\":5123")), Contains("positions are not floats"));
    CHECK_THAT(said("a.glb", changed("{\"byteLength\":168}", "{\"byteLength\":168,\"uri\":\"/etc/passwd\"}")), Contains("a.glb: has its data in another file"));
    CHECK_THAT(said("a.glb", changed("\"scene\":0", "\"scene\":0,\"extensionsRequired\":[\"EXT_meshopt_compression\"]")), Contains("a.glb: needs the extension EXT_meshopt_compression"));
    CHECK_THAT(said("a.glb", changed("\"mesh\":0", "\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{}}")), Contains("a.glb: has instances"));
    CHECK_THAT(said("a.glb", changed("\"children\":[1,2,3]", "\"children\":[1,1]")), Contains("a.glb: node 1 is reached twice"));
    CHECK_THAT(said("a.glb", glb("{\"extras\":" + std::string(200000, '[') + std::string(200000, ']') + "}")), Contains("a.glb: is not a .glb: its JSON is nested too deep"));
    CHECK_THAT(said("a.glb", glb("{\"scenes\":7}")), Contains("a.glb: has no scenes 0") || Contains("a.glb: is not a valid .glb (glTF 2.0)"));
    CHECK_NOTHROW(read_surface_file(folder.file("a.glb", changed("\"scene\":0", "\"scene\":0,\"extensionsRequired\":[\"KHR_materials_unlit\"]"))));
}

}  // namespace tissue
