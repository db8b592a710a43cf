#pragma once

#include <string>
#include <vector>

#include "haptic/device_kinds.h"

namespace tissue {

/// Where the hand is at a time, in the tissue's space; it goes smoothly from one to the next and stays at the last.
struct Waypoint {
    double time_s;
    Point point_m;
};

/// Names of the motions, in the order in which messages list them; what each does stands beside it in the .cpp.
const std::vector<std::string>& motion_names();

struct MotionOptions {
    std::string name = "press";
    double seconds = 10;                 ///< to be filled, up to longest_motion_s
    double depth_m = 0.010;              ///< of the tool below the surface at rest: the paper's smaller magnitude
    unsigned long seed = 2008;           ///< of poke
    const SpringMesh* rest = nullptr;    ///< the tissue
    double aside_m = 0;                  ///< of press, slide and sine: from the middle of the top, along the first axis
};

/// A longer session plays its motion over and over.
constexpr double longest_motion_s = 3600;

/// A motion that starts outside the tissue; one that comes back to where it began but for `press`, which stays. Throws MismatchError for an unknown name, or a depth or time that is not
/// positive.
std::vector<Waypoint> make_motion(const MotionOptions& options);

/// A press at one contact: from outside it to the surface, then `push_m` beyond it within `seconds` and on staying there.
/// inward: unit vector into the tissue. The tool touches `inset_m` inside the surface, so that a push along the
/// surface does not leave it.
std::vector<Waypoint> press_motion(const Point& contact_m, const Point& inward,
                                   const Point& push_m, double seconds, double inset_m);

/// A hand without a body: it follows the waypoints whatever force comes.
class VirtualDevice final : public Device {
   public:
    static const DeviceKind kind;
    /// over_and_over: a motion that ends where it began begins again. Of another it stays at the last waypoint.
    VirtualDevice(std::vector<Waypoint> motion, const DeviceMap& map, bool over_and_over = false);

    std::string name() const override { return kind.name; }
    DeviceSample read(double time_s) noexcept override;
    void write(const Eigen::Vector3d& force_N) noexcept override { force_N_ = force_N; }
    const Eigen::Vector3d& force_N() const { return force_N_; }

   private:
    std::vector<Waypoint> motion_;
    DeviceMap map_;
    std::size_t next_ = 1;   ///< first waypoint after the time asked last
    double again_s_ = 0;     ///< how long the motion takes where it begins again; else 0
    double begun_s_ = 0;     ///< when it has begun the last time
    Eigen::Vector3d force_N_ = Eigen::Vector3d::Zero();
};

}  // namespace tissue
