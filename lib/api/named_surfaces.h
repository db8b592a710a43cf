#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// Surfaces in space that move with a session's tissue, by name: "boundary", the model's own; "nodule", of the other material in it where the model has its surface; and those that are
/// added of files. What an engine maps to a mesh of its own. None in the plane.
class NamedSurfaces {
   public:
    struct Surface {
        std::string name;
        NodeField rest_m;    ///< (V x 3)
        Cells triangles;     ///< of these points, normals out (W x 3)
        Cells node;          ///< of the tissue, which a point moves with (V x 3 or 4)
        NodeField weight;    ///< of these

        /// Where points are, for displacements of the tissue's nodes [m] (N x 3); places: room for V times 3.
        void places(const NodeColumns& displacement_m, double* places_m) const noexcept;
    };

    NamedSurfaces() = default;
    explicit NamedSurfaces(const TissueModel& tissue);

    /// The surface of a file, which moves with the boundary (mesh/carried_surface.h). unit_m [m]: of its numbers. Throws FileError and MismatchError as that and its readers, and where there is one of this name.
    void add(const std::string& name, const std::string& file, double unit_m);

    const Surface* find(std::string_view name) const noexcept;  ///< nullptr: there is none
    std::vector<std::string> names() const;

   private:
    std::shared_ptr<const SpringMesh> mesh_;
    std::vector<std::shared_ptr<const Surface>> all_;
};

}  // namespace tissue
