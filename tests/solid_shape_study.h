#pragma once

#include <string>

#include "example.h"
#include "mesh/dome.h"
#include "study/study.h"

namespace tissue {

/// A study of the dome (tests/mesh/dome.h) with two contacts and five indentations. Its file dome.geo is empty and is
/// never read.
inline const std::string& shape_study_text() {
    static const std::string text = R"([geometry]
solid = true
shape = "dome.geo"
trust_geo = true
unit_m = 0.001
fixed = ["bed"]

[material]
law = "mooney-rivlin"
C1_Pa = 263.0
C2_Pa = 491.0
density_kg_m3 = 1000.0

[lattice]
size_m = 0.01

[mesh]
sizes_m = [0.005, 0.02]
check_sizes_m = [0.004, 0.015]
check_fraction = 0.5

[indenter]
kind = "disc"
radius_m = 0.007

[solver]
tolerance = 1e-9
max_newton = 12

[loads]
magnitudes_m = [0.004, 0.008]
record_step_m = 0.002
contacts = [
  { at_m = [0.0, 0.0, 0.051], pushes_deg = [[0, 0], [30, -90]] },
  { at_m = [0.03, 0.02, 0.04], depth_m = 0.003, pushes_deg = [[0, 0], [30, 0], [30, 180]] },
]

[draws.validation]
seed = 1
count = 10
depth_m = [0.002, 0.008]
tilt_deg = [0, 30]
clearance_m = [0.015, 0.2]

[draws.held_out]
seed = 2
count = 40
depth_m = [0.002, 0.008]
tilt_deg = [10, 30]
clearance_m = [0.012, 0.03]

[springs]
topology = "embedded"
spacing_m = 0.011
stiffness = "law"
terms = ["spring.all", "cell.all"]
)";
    return text;
}

/// The study, read from a temporary folder with an empty dome.geo. The folder is removed on return.
inline Study shape_study(const std::string& text = shape_study_text()) {
    const TemporaryFolder folder;
    folder.file("dome.geo", "");
    return read_study(folder.file("example.toml", text));
}

}  // namespace tissue
