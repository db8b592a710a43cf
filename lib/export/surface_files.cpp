#include "export/surface_files.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "version.h"

namespace tissue {
namespace {

using Json = nlohmann::ordered_json;

template <class Matrix>
std::string numbers(const Matrix& matrix) {
    std::string text;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
        for (Eigen::Index k = 0; k < matrix.cols(); ++k) text += fmt::format("{} ", matrix(i, k));
        text += '\n';
    }
    return text;
}

std::string array(const char* type, const std::string& name, int components, const std::string& values) {
    return fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n{}</DataArray>\n", type, name, components, values);
}

std::string tuple(const char* name, const Point& value) {
    return fmt::format("<DataArray type=\"Float64\" Name=\"{}\" NumberOfComponents=\"3\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n", name, numbers(value.transpose()));
}

std::vector<double> list(const Point& v) {
    return {v.data(), v.data() + v.size()};
}

/// The buffer of a .glb file, and the JSON of its views and accessors.
class Buffer {
   public:
    enum Target { vertices = 34962, indices = 34963 };  // glTF 2.0, 5.11.5

    /// Adds a field of three columns as float32; returns the number of its accessor. bounded: with minimum and maximum,
    /// which glTF requires of positions.
    int add(const NodeField& field, bool bounded) {
        const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> values = field.cast<float>();
        const int accessor = add(values.data(), values.size(), 5126, "VEC3", values.rows(), vertices);
        if (bounded) {
            const Eigen::RowVector3f least = values.colwise().minCoeff(), most = values.colwise().maxCoeff();
            accessors.back()["min"] = std::vector<float>(least.data(), least.data() + 3);
            accessors.back()["max"] = std::vector<float>(most.data(), most.data() + 3);
        }
        return accessor;
    }
    int add(const Cells& facets) {
        const Eigen::Matrix<std::uint32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values = facets.cast<std::uint32_t>();
        return add(values.data(), values.size(), 5125, "SCALAR", values.size(), indices);
    }
    int add(const std::vector<float>& values) {
        const int accessor = add(values.data(), static_cast<Eigen::Index>(values.size()), 5126, "SCALAR", static_cast<Eigen::Index>(values.size()), {});
        accessors.back()["min"] = {values.front()};
        accessors.back()["max"] = {values.back()};
        return accessor;
    }

    Json accessors = Json::array(), views = Json::array();
    std::string bytes;  ///< every number has four bytes

   private:
    template <class Number>
    int add(const Number* values, Eigen::Index numbers, int component, const char* type, Eigen::Index count, std::optional<Target> target) {
        Json view = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", static_cast<std::size_t>(numbers) * sizeof(Number)}};
        if (target) view["target"] = static_cast<int>(*target);
        views.push_back(view);
        bytes.append(reinterpret_cast<const char*>(values), static_cast<std::size_t>(numbers) * sizeof(Number));
        accessors.push_back({{"bufferView", views.size() - 1}, {"componentType", component}, {"type", type}, {"count", count}});
        return static_cast<int>(accessors.size()) - 1;
    }
};

std::string word(std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    return {reinterpret_cast<const char*>(&number), sizeof number};
}

}  // namespace

std::string surface_vtp(const IndentedSurface& indented) {
    const CarriedSurface& s = indented.surface;
    std::string ends;
    for (Eigen::Index f = 1; f <= s.facets.rows(); ++f) ends += fmt::format("{} ", 3 * f);
    return fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n{}{}{}</FieldData>\n"
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n"
        "<PointData Vectors=\"displacement_m\">\n{}{}</PointData>\n<Points>\n{}</Points>\n<Polys>\n{}{}</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n",
        tuple("contact_m", indented.contact_m), tuple("push_m", indented.push_m), tuple("force_N", indented.force_N), s.vertices.rows(), s.facets.rows(),
        array("Float64", "rest_m", 3, numbers(s.vertices)), array("Float64", "displacement_m", 3, numbers((indented.places - s.vertices).eval())),
        array("Float64", "Points", 3, numbers(indented.places)), array("Int64", "connectivity", 1, numbers(s.facets)), array("Int64", "offsets", 1, ends + "\n"));
}

std::string surface_glb(const IndentedSurface& indented) {
    const CarriedSurface& s = indented.surface;
    const NodeField at_rest = vertex_normals(s.vertices, s.facets), pressed = vertex_normals(indented.places, s.facets);
    Buffer buffer;
    Json primitive = {{"attributes", {{"POSITION", buffer.add(s.vertices, true)}, {"NORMAL", buffer.add(at_rest, false)}}}, {"indices", buffer.add(s.facets)}, {"material", 0}};
    primitive["targets"] = Json::array({{{"POSITION", buffer.add(indented.places - s.vertices, true)}, {"NORMAL", buffer.add(pressed - at_rest, false)}}});
    // two accessors with the same values, because an accessor has one use
    const int time_s = buffer.add(std::vector<float>{0, 1}), weight = buffer.add(std::vector<float>{0, 1});
    const Json sampler = {{"input", time_s}, {"output", weight}, {"interpolation", "LINEAR"}};
    const double half = std::sqrt(0.5);
    const Json model = {
        {"asset", {{"version", "2.0"}, {"generator", std::string("tissuectl ") + version}}},
        {"scene", 0},
        {"scenes", Json::array({{{"nodes", {0}}}})},
        {"nodes", Json::array({{{"name", indented.name},
                                {"mesh", 0},
                                {"rotation", {-half, 0, 0, half}},
                                {"extras", {{"case", indented.name}, {"contact_m", list(indented.contact_m)}, {"push_m", list(indented.push_m)}, {"force_N", list(indented.force_N)}}}}})},
        {"meshes", Json::array({{{"name", indented.name}, {"primitives", Json::array({primitive})}, {"weights", {0}}, {"extras", {{"targetNames", {"pressed"}}}}}})},
        {"materials", Json::array({{{"pbrMetallicRoughness", {{"baseColorFactor", {0.72, 0.36, 0.32, 1.0}}, {"metallicFactor", 0}, {"roughnessFactor", 0.6}}}, {"doubleSided", true}}})},
        {"animations", Json::array({{{"name", "press"}, {"samplers", Json::array({sampler})}, {"channels", Json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}})}}})},
        {"accessors", buffer.accessors},
        {"bufferViews", buffer.views},
        {"buffers", Json::array({{{"byteLength", buffer.bytes.size()}}})}};
    std::string text = model.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::string chunks = word(text.size()) + "JSON" + text + word(buffer.bytes.size()) + std::string("BIN\0", 4) + buffer.bytes;
    return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
}

}  // namespace tissue
