#include "mesh/open_faces.h"

#include <algorithm>
#include <array>
#include <map>

namespace tissue {

Cells open_faces(const Cells& tetrahedra) {
    std::map<std::array<int, 3>, std::array<int, 3>> open;
    for (Eigen::Index e = 0; e < tetrahedra.rows(); ++e)
        for (const auto& [i, j, k] : tetrahedron_faces) {
            const std::array<int, 3> face = {tetrahedra(e, i), tetrahedra(e, j), tetrahedra(e, k)};
            std::array<int, 3> key = face;
            std::sort(key.begin(), key.end());
            if (open.erase(key) == 0) open.emplace(key, face);
        }
    Cells faces(static_cast<Eigen::Index>(open.size()), 3);
    Eigen::Index f = 0;
    for (const auto& [key, face] : open) faces.row(f++) << face[0], face[1], face[2];
    return faces;
}

}  // namespace tissue
