#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "error.h"
#include "surface_file/facets.h"

namespace tissue::surface_file {
namespace {

using Json = nlohmann::json;

constexpr int deepest = 64;  // deepest nesting of nodes, and of the JSON itself
// glTF 2.0, sections 3.6 and 3.7
constexpr int triangles_mode = 4, of_bytes = 5121, of_shorts = 5123, of_ints = 5125, of_floats = 5126;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);  // .glb is little-endian, and so are all supported machines
    return value;
}

class Reader {
   public:
    Reader(const std::string& file, const Json& model, std::string_view bytes) : file_(file), model_(model), bytes_(bytes), facets_(file), seen_(part("nodes").size(), false) {}

    Facets read() {
        for (const std::string& name : model_.value("extensionsRequired", std::vector<std::string>{})) {
            const auto begins = [&](std::string_view with) { return name.compare(0, with.size(), with) == 0; };
            if (!begins("KHR_materials_") && !begins("KHR_texture_") && !begins("EXT_texture_")) refuse(fmt::format("needs the extension {}, which is not supported", name));
        }
        if (!part("buffers").empty() && part("buffers").front().contains("uri")) refuse("has its data in another file, which is not supported");
        const Json& scenes = part("scenes");
        if (scenes.empty()) refuse("has no scene");
        for (const Json& node : one_of("scenes", model_.value("scene", 0)).value("nodes", Json::array())) add_node(node, Eigen::Affine3d::Identity(), 0);
        return std::move(facets_);
    }

   private:
    [[noreturn]] void refuse(const std::string& why) const { throw FileError(file_ + ": " + why); }

    const Json& part(const char* name) const {
        static const Json none = Json::array();
        return model_.contains(name) ? model_.at(name) : none;
    }
    const Json& one_of(const char* name, const Json& k) const {
        const Json& all = part(name);
        const auto number = k.get<long long>();
        if (number < 0 || static_cast<std::size_t>(number) >= all.size()) refuse(fmt::format("has no {} {}", name, number));
        return all.at(static_cast<std::size_t>(number));
    }
    template <class Vector>
    Vector numbers(const Json& node, const char* name, const Vector& otherwise) const {
        if (!node.contains(name)) return otherwise;
        const Json& all = node.at(name);
        Vector x = otherwise;
        if (all.size() != static_cast<std::size_t>(x.size())) refuse(fmt::format("a node's {} has {} numbers, must have {}", name, all.size(), x.size()));
        for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = all.at(static_cast<std::size_t>(i)).get<double>();
        return x;
    }

    Eigen::Affine3d place_of(const Json& node) const {
        Eigen::Affine3d place = Eigen::Affine3d::Identity();
        if (node.contains("matrix")) {
            place.matrix() = numbers(node, "matrix", Eigen::Matrix4d(Eigen::Matrix4d::Identity()));
            return place;
        }
        const Eigen::Vector4d turn = numbers(node, "rotation", Eigen::Vector4d(0, 0, 0, 1));
        place.translate(numbers(node, "translation", Eigen::Vector3d(0, 0, 0)));
        place.rotate(Eigen::Quaterniond(turn[3], turn[0], turn[1], turn[2]).normalized());
        place.scale(numbers(node, "scale", Eigen::Vector3d(1, 1, 1)));
        return place;
    }

    void add_node(const Json& k, const Eigen::Affine3d& above, int depth) {
        if (depth == deepest) refuse(fmt::format("has nodes nested {} deep, which is too deep", deepest));
        const Json& node = one_of("nodes", k);
        if (seen_[k.get<std::size_t>()]) refuse(fmt::format("node {} is reached twice; a scene must be a tree", k.get<std::size_t>()));
        seen_[k.get<std::size_t>()] = true;
        const Eigen::Affine3d place = above * place_of(node);
        if (node.contains("skin")) refuse(fmt::format("node {} has a skin, which is not supported", k.get<std::size_t>()));
        if (node.contains("extensions") && node.at("extensions").contains("EXT_mesh_gpu_instancing")) refuse("has instances (EXT_mesh_gpu_instancing), which are not supported");
        if (node.contains("mesh")) {
            const Json& mesh = one_of("meshes", node.at("mesh"));
            const std::string name = mesh.value("name", "");
            facets_.begin_group(node.value("name", "").empty() ? name : node.value("name", ""));
            for (const Json& primitive : mesh.at("primitives")) add(primitive, place, name);
        }
        for (const Json& child : node.value("children", Json::array())) add_node(child, place, depth + 1);
    }

    /// The bytes of an accessor. view() checks its bounds.
    struct View {
        const char* begin;
        std::size_t stride, count;
        int type;
        const char* of(std::size_t n) const { return begin + n * stride; }
    };
    View view(const Json& k, const char* shape, std::size_t components, const std::string& mesh) const {
        const Json& accessor = one_of("accessors", k);
        if (accessor.contains("sparse") || !accessor.contains("bufferView")) refuse(fmt::format("mesh '{}' is sparse or compressed, which is not supported", mesh));
        const Json& all = one_of("bufferViews", accessor.at("bufferView"));
        if (all.contains("extensions") && all.at("extensions").contains("EXT_meshopt_compression")) refuse(fmt::format("mesh '{}' is compressed, which is not supported", mesh));
        if (all.value("buffer", 0) != 0) refuse(fmt::format("mesh '{}' is in a second buffer, which a .glb does not have", mesh));
        const int type = accessor.at("componentType").get<int>();
        const std::size_t each = type == of_bytes ? 1 : type == of_shorts ? 2 : type == of_ints || type == of_floats ? 4 : 0;
        if (accessor.at("type").get<std::string>() != shape || each == 0) refuse(fmt::format("mesh '{}': has a number type that is not one of glTF", mesh));
        const auto number = [&](const Json& of, const char* name, std::uint64_t otherwise) { return of.value(name, otherwise); };
        const std::uint64_t from = number(all, "byteOffset", 0), length = number(all, "byteLength", 0), offset = number(accessor, "byteOffset", 0), count = number(accessor, "count", 0),
                            stride = number(all, "byteStride", each * components);
        const std::uint64_t there = bytes_.size();
        const bool inside = from <= there && length <= there - from && offset <= length && stride >= each * components && stride <= 255 && count <= there && (count == 0 || (count - 1) * stride + each * components <= length - offset);
        if (!inside) refuse(fmt::format("mesh '{}': its data extend beyond their part of the file, of {} bytes", mesh, length));
        return {bytes_.data() + from + offset, static_cast<std::size_t>(stride), static_cast<std::size_t>(count), type};
    }

    void add(const Json& primitive, const Eigen::Affine3d& place, const std::string& name) {
        if (primitive.value("mode", triangles_mode) != triangles_mode) refuse(fmt::format("mesh '{}' has primitives of mode {}; only triangles (4) are read", name, primitive.value("mode", triangles_mode)));
        if (primitive.contains("targets")) refuse(fmt::format("mesh '{}' has morph targets, which are not supported", name));
        if (!primitive.at("attributes").contains("POSITION")) refuse(fmt::format("mesh '{}' has no positions", name));
        const View at = view(primitive.at("attributes").at("POSITION"), "VEC3", 3, name);
        if (at.type != of_floats) refuse(fmt::format("mesh '{}': its positions are not floats", name));
        const auto point = [&](std::uint32_t n) {
            if (n >= at.count) refuse(fmt::format("mesh '{}' names point {} of {}", name, n, at.count));
            Eigen::Vector3f x;
            std::memcpy(x.data(), at.of(n), sizeof x);
            const Eigen::Vector3d p = place * x.cast<double>();
            return MshFile::Point{p.x(), p.y(), p.z()};
        };
        std::optional<View> indices;
        if (primitive.contains("indices")) indices = view(primitive.at("indices"), "SCALAR", 1, name);
        if (indices && indices->type == of_floats) refuse(fmt::format("mesh '{}': its indices are not whole numbers", name));
        const auto corner = [&](std::size_t n) {
            auto value = static_cast<std::uint32_t>(n);
            if (indices) value = 0, std::memcpy(&value, indices->of(n), indices->type == of_bytes ? 1 : indices->type == of_shorts ? 2 : 4);
            return point(value);
        };
        const std::size_t count = indices ? indices->count : at.count;
        if (count % 3 != 0) refuse(fmt::format("mesh '{}' has {} corners of triangles, not a multiple of 3", name, count));
        const bool mirrored = place.linear().determinant() < 0;  // then the winding is reversed (glTF 2.0, 3.5.3)
        for (std::size_t c = 0; c < count; c += 3) facets_.add({corner(c), corner(c + (mirrored ? 2 : 1)), corner(c + (mirrored ? 1 : 2))});
    }

    const std::string& file_;
    const Json& model_;
    std::string_view bytes_;
    Facets facets_;
    std::vector<bool> seen_;
};

}  // namespace

Facets read_glb(const std::string& file, std::string_view content) try {
    constexpr std::size_t head = 12, chunk = 8;
    const auto refuse = [&](const char* why) { throw FileError(fmt::format("{}: is not a .glb: {}", file, why)); };
    if (content.size() < head + chunk || content.substr(0, 4) != "glTF") refuse("it does not begin with 'glTF' and its lengths");
    if (word_at(content, 4) != 2) refuse("its version is not 2");
    const std::size_t length = word_at(content, head);
    if (content.substr(head + 4, 4) != "JSON" || length > content.size() - head - chunk) refuse("its JSON is truncated");
    const Json model = Json::parse(content.substr(head + chunk, length), [&](int depth, Json::parse_event_t, Json&) {
        if (depth > deepest) refuse("its JSON is nested too deeply");
        return true;
    });
    std::string_view bytes = content.substr(head + chunk + length);
    if (bytes.size() >= chunk) {
        const std::size_t there = word_at(bytes, 0);
        if (bytes.substr(4, 4) != std::string_view("BIN\0", 4) || there > bytes.size() - chunk) refuse("its data are truncated");
        bytes = bytes.substr(chunk, there);
    } else {
        bytes = {};
    }
    return Reader(file, model, bytes).read();
} catch (const Json::exception& e) {
    throw FileError(fmt::format("{}: is not a valid .glb (glTF 2.0): {}", file, e.what()));
}

}  // namespace tissue::surface_file
