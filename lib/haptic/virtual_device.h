#pragma once

#include <string>
#include <vector>

#include "haptic/device_kinds.h"

namespace tissue {

/// Position of the hand at a time, in the tissue's space. The hand moves smoothly from one waypoint to the next, and
/// stays at the last.
struct Waypoint {
    double time_s;
    Point point_m;
    bool grasp = false;  ///< the tool grasps from here to the next waypoint
};

/// Names of the motions, in the order in which messages list them. The functions of the .cpp describe them.
const std::vector<std::string>& motion_names();

struct MotionOptions {
    std::string name = "press";
    double seconds = 10;                 ///< least duration, up to longest_motion_s; not used by press
    double depth_m = 0.010;              ///< of the tool below the surface at rest: the paper's smaller magnitude
    unsigned long seed = 2008;           ///< of poke and probe
    const SpringMesh* rest = nullptr;    ///< the tissue at rest
    double aside_m = 0;                  ///< of press, slide, sine and pull: from the middle of the top, along the first axis
};

/// A longer session repeats its motion.
constexpr double longest_motion_s = 3600;

/// Waypoints of a motion. It starts outside the tissue and returns to its start, except `press`, which stays in the
/// tissue. Throws MismatchError for an unknown name, for a depth or time that is not positive, without a tissue, and
/// for an aside_m outside the tissue or of poke or probe.
std::vector<Waypoint> make_motion(const MotionOptions& options);

/// Waypoints of an indentation at one contact: from outside to the surface, then to push_m beyond it after `seconds` in
/// all, where the tool stays. inward: unit vector into the tissue. The tool touches inset_m inside the surface, so that
/// a displacement along the surface does not leave it.
std::vector<Waypoint> indentation_motion(const Point& contact_m, const Point& inward,
                                   const Point& push_m, double seconds, double inset_m);

/// A scripted hand without mass: it follows the waypoints whatever the force.
class VirtualDevice final : public Device {
   public:
    static const DeviceKind kind;
    /// over_and_over: whether a motion that ends where it began is repeated; any other stays at its last waypoint.
    /// Throws MismatchError without waypoints, and as DeviceMap::fit.
    VirtualDevice(std::vector<Waypoint> motion, const DeviceMap& map, bool over_and_over = false);

    std::string name() const override { return kind.name; }
    DeviceSample read(double time_s) noexcept override;
    void write(const Eigen::Vector3d& force_N) noexcept override { force_N_ = force_N; }
    const Eigen::Vector3d& force_N() const { return force_N_; }

   private:
    std::vector<Waypoint> motion_;
    DeviceMap map_;
    std::size_t next_ = 1;   ///< first waypoint after the time of the last read()
    double again_s_ = 0;     ///< duration of a motion that is repeated; else 0
    double begun_s_ = 0;     ///< start of the present repetition
    Eigen::Vector3d force_N_ = Eigen::Vector3d::Zero();
};

}  // namespace tissue
