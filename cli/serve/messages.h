#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "fe_outline.h"

namespace tissue::serve {

/// What a page can say (cli/view/PROTOCOL.md).
struct PointerMessage { double x_m, y_m; std::optional<double> z_m; bool down; int tool = 0; };  ///< z of models in space
struct PauseMessage { bool on; };
struct ResetMessage {};
struct DemoMessage { int place; };
struct ModelMessage { int model; };
using Message = std::variant<PointerMessage, PauseMessage, ResetMessage, DemoMessage, ModelMessage>;

inline constexpr std::size_t longest_message = 1024;  ///< bytes

/// Why something was not let in: a word to count it by, and a sentence for whoever sent it.
struct Refusal {
    const char* kind;
    std::string reason;
};

/// Reads one message of a page. Whatever comes in, it is a Message or a Refusal of kind `message`.
std::variant<Message, Refusal> parse_message(std::string_view text);

/// {"type": "bye", "reason": ...}
std::string bye_message(const std::string& reason);

/// {"type": "near", ...}; displacements to 0.1 um.
std::string near_message(int place, double distance_m, const std::vector<FeOutline>& outlines);

/// {"type": "control", ...}; holders: of each tool.
std::string control_message(const char* holder, const std::vector<const char*>& holders, bool paused, int place);

}  // namespace tissue::serve
