#include "solid_example.h"

namespace tissue {

const std::string& solid_study_text() {
    static const std::string text = R"([geometry]
width_m = 0.1
length_m = 0.08
height_m = 0.05

[material]
law = "mooney-rivlin"
C1_Pa = 263.0
C2_Pa = 491.0
density_kg_m3 = 1000.0

[lattice]
cells = [5, 4, 3]

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
magnitudes_m = [0.004, 0.010]
record_step_m = 0.002
contacts = [
  { at_m = [0.05, 0.04], pushes_deg = [[0, 0], [30, -90]] },
  { at_m = [0.012, 0.015], pushes_deg = [[0, 0]] },
  { at_m = [0.05, 0.04], depth_m = 0.003, pushes_deg = [[90, 90]] },
]

[draws.validation]
seed = 1
count = 10
depth_m = [0.002, 0.01]
tilt_deg = [0, 30]
clearance_m = [0.02, 0.05]

[draws.held_out]
seed = 2
count = 40
depth_m = [0.002, 0.008]
tilt_deg = [10, 30]
clearance_m = [0.015, 0.05]

[draws.held_out_near_a_wall]
seed = 3
count = 20
depth_m = [0.001, 0.003]
tilt_deg = [90, 90]
clearance_m = [0.012, 0.02]

[springs]
topology = "embedded"
spacing_m = 0.0125
stiffness = "law"
terms = ["spring.all", "cell.all"]

[training]
force_scale = 0.02

[nodule]
centre_m = [0.06, 0.04, 0.025]
radius_m = 0.008
C1_Pa = 1000.0
C2_Pa = 2000.0
)";
    return text;
}

}  // namespace tissue
