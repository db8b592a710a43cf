#include "haptic/moving_surface.h"

#include "haptic/moving_outline.h"
#include "haptic/moving_triangles.h"

namespace tissue {

std::unique_ptr<MovingSurface> make_moving_surface(const SpringMesh& mesh) {
    if (mesh.is_solid()) return std::make_unique<MovingTriangles>(mesh);
    return std::make_unique<MovingOutline>(mesh);
}

}  // namespace tissue
