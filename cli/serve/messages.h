#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "fe_outline.h"

namespace tissue::serve {

/// Messages of a page (cli/view/PROTOCOL.md).
/// z only for models in space
struct PointerMessage { double x_m, y_m; std::optional<double> z_m; bool down; int tool = 0; bool grasp = false; };
struct PauseMessage { bool on; };
struct ResetMessage {};
struct DemoMessage { int place; };
struct ModelMessage { int model; };
using Message = std::variant<PointerMessage, PauseMessage, ResetMessage, DemoMessage, ModelMessage>;

inline constexpr std::size_t longest_message = 1024;  ///< bytes

/// Why something was refused: a keyword for the counts, and a sentence for the sender.
struct Refusal {
    const char* kind;
    std::string reason;
};

/// Parses one message of a page. Any other input gives a Refusal, of kind `message` or `too_long`.
std::variant<Message, Refusal> parse_message(std::string_view text);

/// {"type": "bye", "reason": ...}
std::string bye_message(const std::string& reason);

/// {"type": "near", ...}; displacements are rounded to 0.1 um.
std::string near_message(int place, double distance_m, const std::vector<FeOutline>& outlines);

/// {"type": "control", ...}; holders: one per tool.
std::string control_message(const char* holder, const std::vector<const char*>& holders, bool paused, int place);

}  // namespace tissue::serve
