#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <cstring>

#include "error.h"
#include "io/one_line.h"
#include "surface_file/facets.h"

namespace tissue::surface_file {
namespace {

constexpr int deepest = 64;  // of nodes within nodes

class Reader {
   public:
    Reader(const std::string& file, const tinygltf::Model& model) : file_(file), model_(model), facets_(file) {}

    Facets read() {
        if (model_.scenes.empty()) refuse("has no scene");
        const std::size_t scene = static_cast<std::size_t>(std::max(model_.defaultScene, 0));
        if (scene >= model_.scenes.size()) refuse(fmt::format("has no scene {}", scene));
        for (int node : model_.scenes[scene].nodes) add_node(node, Eigen::Affine3d::Identity(), 0);
        return std::move(facets_);
    }

   private:
    [[noreturn]] void refuse(const std::string& why) const { throw FileError(file_ + ": " + why); }

    template <class Of>
    const Of& one_of(const std::vector<Of>& all, int k, const char* name) const {
        if (k < 0 || static_cast<std::size_t>(k) >= all.size()) refuse(fmt::format("has no {} {}", name, k));
        return all[static_cast<std::size_t>(k)];
    }

    static Eigen::Affine3d place_of(const tinygltf::Node& node) {
        Eigen::Affine3d place = Eigen::Affine3d::Identity();
        if (node.matrix.size() == 16) {
            place.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
            return place;
        }
        if (node.translation.size() == 3) place.translate(Eigen::Map<const Eigen::Vector3d>(node.translation.data()));
        if (node.rotation.size() == 4) place.rotate(Eigen::Quaterniond(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]).normalized());
        if (node.scale.size() == 3) place.scale(Eigen::Map<const Eigen::Vector3d>(node.scale.data()));
        return place;
    }

    void add_node(int k, const Eigen::Affine3d& above, int depth) {
        if (depth == deepest) refuse(fmt::format("has nodes within nodes, {} deep", deepest));
        const tinygltf::Node& node = one_of(model_.nodes, k, "node");
        const Eigen::Affine3d place = above * place_of(node);
        if (node.skin >= 0) refuse(fmt::format("node '{}' has a skin, which is not read", node.name));
        if (node.mesh >= 0) {
            const tinygltf::Mesh& mesh = one_of(model_.meshes, node.mesh, "mesh");
            facets_.begin_group(node.name.empty() ? mesh.name : node.name);
            for (const tinygltf::Primitive& part : mesh.primitives) add(part, place, mesh.name);
        }
        for (int child : node.children) add_node(child, place, depth + 1);
    }

    void add(const tinygltf::Primitive& part, const Eigen::Affine3d& place, const std::string& name) {
        if (part.mode != TINYGLTF_MODE_TRIANGLES && part.mode != -1) refuse(fmt::format("mesh '{}' has primitives of mode {}; triangles (4) are read", name, part.mode));
        const auto position = part.attributes.find("POSITION");
        if (position == part.attributes.end()) refuse(fmt::format("mesh '{}' has no positions", name));
        const Values at(*this, position->second, name);
        if (at.accessor.type != TINYGLTF_TYPE_VEC3 || at.accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) refuse(fmt::format("mesh '{}': its positions are not three floats", name));
        std::vector<MshFile::Point> points;
        for (std::size_t n = 0; n < at.accessor.count; ++n) {
            Eigen::Vector3f x;
            std::memcpy(x.data(), at.of(n), sizeof x);
            const Eigen::Vector3d p = place * x.cast<double>();
            points.push_back({p.x(), p.y(), p.z()});
        }
        std::vector<long long> corners;
        if (part.indices < 0) {
            for (std::size_t n = 0; n < points.size(); ++n) corners.push_back(static_cast<long long>(n));
        } else {
            const Values indices(*this, part.indices, name);
            if (indices.accessor.type != TINYGLTF_TYPE_SCALAR) refuse(fmt::format("mesh '{}': its indices are no numbers", name));
            for (std::size_t n = 0; n < indices.accessor.count; ++n) corners.push_back(indices.whole(n));
        }
        if (corners.size() % 3 != 0) refuse(fmt::format("mesh '{}' has {} corners of triangles", name, corners.size()));
        for (std::size_t c = 0; c < corners.size(); c += 3) facets_.add(points, {corners[c], corners[c + 1], corners[c + 2]});
    }

    /// What an accessor shows of a buffer, whose bounds are checked.
    struct Values {
        Values(const Reader& reader, int k, const std::string& name) : accessor(reader.one_of(reader.model_.accessors, k, "accessor")) {
            if (accessor.sparse.isSparse || accessor.bufferView < 0) reader.refuse(fmt::format("mesh '{}' is sparse or compressed, which is not read", name));
            const tinygltf::BufferView& view = reader.one_of(reader.model_.bufferViews, accessor.bufferView, "bufferView");
            const std::vector<unsigned char>& bytes = reader.one_of(reader.model_.buffers, view.buffer, "buffer").data;
            const int each = accessor.ByteStride(view), whole = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType)) * tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
            const bool small = std::max({view.byteOffset, view.byteLength, accessor.byteOffset, accessor.count}) <= bytes.size() && view.byteOffset + view.byteLength <= bytes.size();
            if (each <= 0 || whole <= 0 || !small || (accessor.count > 0 && accessor.byteOffset + static_cast<std::size_t>(each) * (accessor.count - 1) + static_cast<std::size_t>(whole) > view.byteLength))
                reader.refuse(fmt::format("mesh '{}': its numbers lie beyond their part of the file, of {} bytes", name, view.byteLength));
            begin = bytes.data() + view.byteOffset + accessor.byteOffset;
            stride = static_cast<std::size_t>(each);
            refuse_type = [&reader, name] { reader.refuse(fmt::format("mesh '{}': its indices are no whole numbers without a sign", name)); };
        }
        const unsigned char* of(std::size_t n) const { return begin + n * stride; }
        long long whole(std::size_t n) const {
            const auto as = [&](auto value) {
                std::memcpy(&value, of(n), sizeof value);
                return static_cast<long long>(value);
            };
            if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return as(std::uint8_t{});
            if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return as(std::uint16_t{});
            if (accessor.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) refuse_type();
            return as(std::uint32_t{});
        }

        const tinygltf::Accessor& accessor;
        const unsigned char* begin = nullptr;
        std::size_t stride = 0;
        std::function<void()> refuse_type;
    };

    const std::string& file_;
    const tinygltf::Model& model_;
    Facets facets_;
};

}  // namespace

Facets read_glb(const std::string& file, std::string_view content) {
    tinygltf::TinyGLTF loader;
    // whatever lies in another file is not looked for
    loader.SetFsCallbacks({[](const std::string&, void*) { return false; }, [](const std::string& name, void*) { return name; },
                           [](std::vector<unsigned char>*, std::string*, const std::string&, void*) { return false; },
                           [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) { return false; }, nullptr});
    loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int, void*) { return true; }, nullptr);
    tinygltf::Model model;
    std::string error, warning;
    if (!loader.LoadBinaryFromMemory(&model, &error, &warning, reinterpret_cast<const unsigned char*>(content.data()), static_cast<unsigned int>(content.size())))
        throw FileError(one_line(fmt::format("{}: is no .glb: {}", file, error)));
    return Reader(file, model).read();
}

}  // namespace tissue::surface_file
