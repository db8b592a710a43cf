#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tissue {

/// Rigid tool of a session in space: a disc of the tissue model (springs/disc_contact.h) or a ball.
struct ToolChoice {
    enum class Shape { disc, ball };
    Shape shape = Shape::disc;
    double radius_m = 0;  ///< 0: the model's own disc

    bool is_default() const { return shape == Shape::disc && radius_m == 0; }
    bool operator==(const ToolChoice& other) const { return shape == other.shape && radius_m == other.radius_m; }
};

const char* to_string(ToolChoice::Shape shape);

/// Parses "disc", "disc:5mm", "ball:4mm", "ball:0.004": a shape and its radius, in metres or with the unit m or mm.
/// Throws MismatchError for any other text, a radius outside (0, 1) m, and a ball without radius.
ToolChoice tool_choice(const std::string& text);
std::string to_string(const ToolChoice& tool);  ///< inverse of tool_choice()

/// Tools of a session: one for each of its devices, or one for all.
using ToolChoices = std::vector<ToolChoice>;
/// Parses a list "disc:7mm,ball:4mm". Throws as tool_choice().
ToolChoices tool_choices(const std::string& text);
std::string to_string(const ToolChoices& tools);  ///< inverse of tool_choices()
/// The tool of one device, from a list that is not empty.
inline const ToolChoice& choice_of(const ToolChoices& tools, std::size_t device) { return tools[device < tools.size() ? device : 0]; }
bool all_default(const ToolChoices& tools);

}  // namespace tissue
