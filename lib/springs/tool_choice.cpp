#include "springs/tool_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "error.h"

namespace tissue {

const char* to_string(ToolChoice::Shape shape) { return shape == ToolChoice::Shape::ball ? "ball" : "disc"; }

ToolChoice tool_choice(const std::string& text) {
    const auto refuse = [&](const std::string& why) { throw MismatchError(fmt::format("tool '{}': {}; write disc, disc:RADIUS or ball:RADIUS, as ball:4mm or ball:0.004 (m)", text, why)); };
    const std::size_t colon = text.find(':');
    const std::string shape = text.substr(0, colon);
    ToolChoice tool;
    if (shape == "ball")
        tool.shape = ToolChoice::Shape::ball;
    else if (shape != "disc")
        refuse("the shape is not known");
    if (colon == std::string::npos) {
        if (tool.shape == ToolChoice::Shape::ball) refuse("a ball needs a radius");
        return tool;
    }
    std::string radius = text.substr(colon + 1);
    const auto ends_in = [&](const std::string& unit) { return radius.size() > unit.size() && radius.compare(radius.size() - unit.size(), unit.size(), unit) == 0; };
    const bool is_mm = ends_in("mm");
    if (is_mm || ends_in("m")) radius.resize(radius.size() - (is_mm ? 2 : 1));
    // not a division: 4.2mm must give exactly 0.0042
    if (is_mm) radius += "e-3";
    const auto [end, error] = std::from_chars(radius.data(), radius.data() + radius.size(), tool.radius_m);
    if (error != std::errc() || end != radius.data() + radius.size()) refuse("the radius is not a number of m or mm");
    if (!(tool.radius_m > 0 && tool.radius_m < 1)) refuse("the radius must lie in (0, 1) m");
    return tool;
}

std::string to_string(const ToolChoice& tool) { return tool.radius_m == 0 ? to_string(tool.shape) : fmt::format("{}:{}", to_string(tool.shape), tool.radius_m); }

ToolChoices tool_choices(const std::string& text) {
    ToolChoices tools;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        tools.push_back(tool_choice(text.substr(begin, end - begin)));
        begin = end + 1;
    }
    return tools;
}

std::string to_string(const ToolChoices& tools) {
    std::string text;
    for (const ToolChoice& tool : tools) text += (text.empty() ? "" : ",") + to_string(tool);
    return text;
}

bool all_default(const ToolChoices& tools) {
    return std::all_of(tools.begin(), tools.end(), [](const ToolChoice& tool) { return tool.is_default(); });
}

}  // namespace tissue
