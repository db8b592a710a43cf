#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// Surfaces in space that move with a session's tissue, by name. "boundary": the model's own. "nodule": the surface of
/// the inclusion, where the model has it. Others are added from files. An engine maps them to its own meshes. There are
/// none in the plane.
class NamedSurfaces {
   public:
    struct Surface {
        std::string name;
        NodeField rest_m;    ///< vertices at rest (V x 3)
        Cells triangles;     ///< vertex numbers, normals outward (W x 3)
        Cells node;          ///< tissue nodes that carry a vertex (V x 3 or 4)
        NodeField weight;    ///< weights of these nodes

        /// Vertex positions [m] for displacements of the tissue's nodes [m] (N x 3). places_m: room for V times 3
        /// numbers.
        void places(const NodeColumns& displacement_m, double* places_m) const noexcept;
    };

    NamedSurfaces() = default;
    explicit NamedSurfaces(const TissueModel& tissue);

    /// Adds the surface of a file, carried by the boundary (mesh/carried_surface.h). unit_m: unit of the file's numbers
    /// [m], in (0, 1000]. Throws FileError where the file cannot be read. Throws MismatchError for an empty name or one
    /// in use, a unit out of range, a model in the plane, and where carried_surface() throws it.
    void add(const std::string& name, const std::string& file, double unit_m);

    const Surface* find(std::string_view name) const noexcept;  ///< nullptr: no surface has this name
    std::vector<std::string> names() const;

   private:
    std::shared_ptr<const SpringMesh> mesh_;
    std::vector<std::shared_ptr<const Surface>> all_;
};

}  // namespace tissue
