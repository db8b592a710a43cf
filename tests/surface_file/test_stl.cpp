#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <array>
#include <string>

#include "error.h"
#include "mesh/surface.h"
#include "surface_file/surface_file.h"
#include "../refusal.h"
#include "../example.h"

namespace tissue {
namespace {

using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;

using Corners = std::array<std::array<double, 3>, 3>;

/// Sides of a box of 2 x 3 x 4, two facets each, normals out: z = 0, z = 4, then the four vertical ones.
std::vector<Corners> box_facets() {
    const auto corner = [](int i) { return std::array<double, 3>{i & 1 ? 2. : 0., i & 2 ? 3. : 0., i & 4 ? 4. : 0.}; };
    std::vector<Corners> facets;
    for (const auto& [a, b, c, d] : {std::array<int, 4>{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
        facets.push_back({corner(a), corner(b), corner(c)});
        facets.push_back({corner(a), corner(c), corner(d)});
    }
    return facets;
}

std::string solid(const std::string& name, std::size_t from, std::size_t to, const std::string& end = "\n") {
    const std::vector<Corners> all = box_facets();
    std::string text = "solid" + name + end;
    for (std::size_t f = from; f < to; ++f) {
        text += "facet normal 0 0 0" + end + "  outer loop" + end;
        for (const auto& c : all[f]) text += "    vertex " + std::to_string(c[0]) + " " + std::to_string(c[1]) + " " + std::to_string(c[2]) + end;
        text += "  endloop" + end + "endfacet" + end;
    }
    return text + "endsolid" + name + end;
}

std::string binary(const std::string& head, std::uint32_t count) {
    std::string bytes = head;
    bytes.resize(80, '\0');
    bytes.append(reinterpret_cast<const char*>(&count), 4);
    for (const Corners& corners : box_facets()) {
        bytes.append(12, '\0');
        for (const auto& c : corners)
            for (double x : c) {
                const auto single = static_cast<float>(x);
                bytes.append(reinterpret_cast<const char*>(&single), 4);
            }
        bytes.append(2, '\0');
    }
    return bytes;
}

/// Area of the fixed triangles.
double held_area(const MshFile& mesh, const std::string& name) {
    const Surface s = make_surface(mesh, {name}, 1);
    double area = 0;
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
        if (s.label[static_cast<std::size_t>(t)] == Surface::fixed_label)
            area += (s.corner(t, 1) - s.corner(t, 0)).cross(s.corner(t, 2) - s.corner(t, 0)).norm() / 2;
    return area;
}

std::string upper(std::string text) {
    for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
}

}  // namespace

TEST_CASE("an ASCII .stl is read with shared points and the names of its solids", "[stl]") {
    const TemporaryFolder folder;
    const MshFile mesh = read_surface_file(folder.file("box.stl", solid(" bed", 0, 2) + solid(" top", 2, 4) + solid(" sides", 4, 12)));
    CHECK(mesh.points.size() == 8);
    CHECK(mesh.triangles.size() == 12);
    CHECK(mesh.triangle_names == std::map<int, std::string>{{1, "bed"}, {2, "top"}, {3, "sides"}});
    CHECK(held_area(mesh, "bed") == Approx(6));
    CHECK(held_area(mesh, "sides") == Approx(40));
}

TEST_CASE("a solid of an .stl without a name gets its number as name; the others keep theirs", "[stl]") {
    const TemporaryFolder folder;
    for (const char* none : {"", " ", "\t", " \r"}) {
        CAPTURE(none);
        const MshFile mesh = read_surface_file(folder.file("box.stl", solid(none, 0, 4) + solid(" sides", 4, 12)));
        CHECK(mesh.triangle_names == std::map<int, std::string>{{1, "1"}, {2, "sides"}});
        CHECK(held_area(mesh, "sides") == Approx(40));
        CHECK(held_area(mesh, "1") == Approx(12));
    }
    const MshFile none = read_surface_file(folder.file("box.stl", solid("", 0, 4) + solid("", 4, 12)));
    CHECK(none.triangle_names.empty());
    // ambiguous: the number is the name of another solid
    CHECK_THAT(refusal<FileError>([&] { read_surface_file(folder.file("box.stl", solid("", 0, 2) + solid(" 1", 2, 4) + solid(" sides", 4, 12))); }),
               Contains("box.stl") && Contains("part 1 has no name, and another part has the name '1'"));
    CHECK(held_area(none, "surface-1") == Approx(12));  // a part between creases
}

TEST_CASE("line ends and blanks and the case of keywords do not change what is read from an .stl", "[stl]") {
    const TemporaryFolder folder;
    const std::string plain = solid(" left lobe", 0, 2) + solid(" rest", 2, 12), dos = solid(" left lobe", 0, 2, "\r\n") + solid(" rest", 2, 12, "\r\n");
    const std::string blank = "\n \n" + solid("  \tleft lobe  ", 0, 2, "\n\n \t") + solid(" rest ", 2, 12);
    for (const std::string& text : {plain, dos, blank}) {
        const MshFile mesh = read_surface_file(folder.file("box.stl", text));
        CHECK(mesh.triangle_names == std::map<int, std::string>{{1, "left lobe"}, {2, "rest"}});
        CHECK(held_area(mesh, "left lobe") == Approx(6));
    }
    CHECK(held_area(read_surface_file(folder.file("BOX.STL", upper(plain))), "LEFT LOBE") == Approx(6));
    CHECK(is_surface_file("a.stl"));
    CHECK(is_surface_file("A.STL"));
    CHECK_FALSE(is_surface_file(".stl"));
    CHECK_FALSE(is_surface_file("a.stl.msh"));
}

TEST_CASE("a binary .stl is read with any text in its header", "[stl]") {
    const TemporaryFolder folder;
    for (const char* head : {"", "made by somebody", "solid of somebody", "solid\n"}) {
        CAPTURE(head);
        const MshFile mesh = read_surface_file(folder.file("box.stl", binary(head, 12)));
        CHECK(mesh.points.size() == 8);
        CHECK(mesh.triangles.size() == 12);
        CHECK(held_area(mesh, "surface-6") == Approx(6));
        CHECK(read_surface_file(folder.file("box.stl", binary(head, 12) + std::string(10, '\0'))).triangles.size() == 12);
    }
}

TEST_CASE("corners that differ by rounding are merged; a facet with fewer than three corners is dropped", "[stl]") {
    const TemporaryFolder folder;
    std::string text = solid(" box", 0, 12);
    const std::string corner = "2.000000 3.000000 4.000000";
    text.replace(text.find(corner), corner.size(), "2.00000001 2.99999999 4");
    const std::string facet = "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 0.00000001\nvertex 2 3 4\nendloop\nendfacet\n";
    text.insert(text.find("endsolid"), facet);
    const MshFile mesh = read_surface_file(folder.file("box.stl", text));
    CHECK(mesh.points.size() == 8);
    CHECK(mesh.triangles.size() == 12);
}

TEST_CASE("an invalid or truncated .stl is refused with file, place and cause", "[stl]") {
    const TemporaryFolder folder;
    const auto said = [&](const std::string& text) { return refusal<FileError>([&] { read_surface_file(folder.file("box.stl", text)); }); };
    const std::string good = solid(" box", 0, 12), cut = good.substr(0, good.find("endloop"));
    CHECK_THAT(said(""), Contains("box.stl: is not an .stl"));
    CHECK_THAT(said("SystemCall \"rm\";\n"), Contains("box.stl: is not an .stl"));
    CHECK_THAT(said(cut), EndsWith("box.stl: is truncated: 'endloop' is missing"));
    CHECK_THAT(said(good.substr(0, good.find("endsolid"))), Contains("'endsolid' is missing"));
    CHECK_THAT(said("solid a\nendsolid a\n"), EndsWith("box.stl: has no facets"));
    CHECK_THAT(said("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n"), Contains("box.stl:4: is not 'vertex x y z'"));
    for (const char* number : {"nan", "inf", "1,5", "0x10", "", "1 2", "1e999"})
        CHECK_THAT(said("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 " + std::string(number) + "\n"), Contains("box.stl:4: "));
    CHECK_THAT(said("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 1e13\n"), Contains("beyond 1e+12"));
    CHECK_THAT(said(good + "SystemCall\n"), Contains("is not 'solid'"));
    CHECK_THAT(said(good + good.substr(good.find("facet"))), Contains("is not 'solid'"));
    CHECK_THAT(said(binary("x", 12).substr(0, 300)), Contains("states 12 facets, which need 684 bytes; the file has 300"));
    CHECK_THAT(said(binary("solid x", 62)), Contains("states 62 facets, which need 3184 bytes; the file has 684"));
    CHECK_THAT(said(binary("x", 4'000'000'000u)), Contains("the file has 684"));
    std::string broken = binary("x", 12);
    const std::uint32_t not_a_number = 0x7fc00000u;
    std::memcpy(&broken[84 + 50 + 12], &not_a_number, 4);
    CHECK_THAT(said(broken), Contains("facet 2 has a coordinate that is not a finite number"));
}

}  // namespace tissue
