#pragma once

#include <string>
#include <vector>

#include "haptic/realtime_loop.h"
#include "eval/session_indentation.h"

namespace tissue::cli {

/// Text about the session before the first tick: meshes, steps, and the limits and scales of each tool. devices: one
/// per tool, here and below.
std::string describe(const std::string& program, const Simulation& simulation, const std::vector<Device*>& devices);

/// Session statistics as text.
std::string statistics_text(const std::string& model_file, const std::vector<Device*>& devices, const Simulation& simulation, const LoopReport& report, long long dropped_samples);

/// Session statistics as `tissue-haptic --json` prints it (results/FORMATS.md).
std::string statistics_json(const std::string& model_file, const std::vector<Device*>& devices, const Simulation& simulation, const LoopReport& report, long long dropped_samples);

/// realtime.json: forces of the running simulation against the static solution and the FE reference, and switches of
/// spring sets.
std::string realtime_json(const HapticModel& model, const std::vector<IndentationResult>& presses,
                          const std::vector<SwitchJump>& jumps);

}  // namespace tissue::cli
