#pragma once

#include <string>
#include <vector>

#include "haptic/realtime_loop.h"
#include "eval/truth_in_motion.h"

namespace tissue::cli {

/// What runs, for people, before the first tick: meshes, steps, and of each tool limits and scales. devices: of the tools, here and below.
std::string describe(const std::string& program, const Simulation& simulation, const std::vector<Device*>& devices);

/// Session statistics, for people.
std::string statistics_text(const std::string& model_file, const std::vector<Device*>& devices, const Simulation& simulation, const LoopReport& report, long long dropped_samples);

/// Session statistics as `tissue-haptic --json` prints it (results/FORMATS.md).
std::string statistics_json(const std::string& model_file, const std::vector<Device*>& devices, const Simulation& simulation, const LoopReport& report, long long dropped_samples);

/// realtime.json: the simulation in motion against the static answer and FE, and switches of spring sets.
std::string realtime_json(const HapticModel& model, const std::vector<PressResult>& presses,
                          const std::vector<SwitchJump>& jumps);

}  // namespace tissue::cli
