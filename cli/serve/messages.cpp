#include "messages.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace tissue::serve {
namespace {

using Json = nlohmann::ordered_json;

/// Thrown only within this file.
struct Wrong {
    std::string reason;
};

/// The keys of one message. no_more() refuses keys that were not read.
class Keys {
   public:
    explicit Keys(const Json& j) : j_(j) {}
    double number(const char* key) {
        const Json& value = at(key);
        const double x = value.is_number() ? value.get<double>() : std::nan("");
        if (!std::isfinite(x)) throw Wrong{fmt::format("'{}' must be a finite number", key)};
        return x;
    }
    std::optional<double> number_if_there(const char* key) {
        if (!j_.contains(key)) return {};
        return number(key);
    }
    int integer(const char* key, int low) {
        const Json& value = at(key);
        if (!value.is_number_integer() || value.get<double>() < low || value.get<double>() > 1e6)
            throw Wrong{fmt::format("'{}' must be an integer from {}", key, low)};
        return value.get<int>();
    }
    bool flag(const char* key) {
        const Json& value = at(key);
        if (!value.is_boolean()) throw Wrong{fmt::format("'{}' must be true or false", key)};
        return value.get<bool>();
    }
    bool flag_if_there(const char* key) { return j_.contains(key) && flag(key); }
    void no_more() const {
        if (j_.size() != asked_) throw Wrong{"a key that a message of this type does not have"};
    }

   private:
    const Json& at(const char* key) {
        const auto found = j_.find(key);
        if (found == j_.end()) throw Wrong{fmt::format("'{}' is missing", key)};
        ++asked_;
        return *found;
    }
    const Json& j_;
    std::size_t asked_ = 1;  // the key "type"
};

Message read(const Json& j) {
    if (!j.is_object()) throw Wrong{"a message must be a JSON object"};
    const auto type = j.find("type");
    if (type == j.end() || !type->is_string()) throw Wrong{"a message must have a 'type'"};
    Keys keys(j);
    Message message;
    if (*type == "pointer") {
        const double x = keys.number("x"), y = keys.number("y");
        const std::optional<double> z = keys.number_if_there("z");
        const int tool = j.contains("tool") ? keys.integer("tool", 0) : 0;
        const bool down = keys.flag("down");
        message = PointerMessage{x, y, z, down, tool, keys.flag_if_there("grasp")};
    } else if (*type == "pause") {
        message = PauseMessage{keys.flag("on")};
    } else if (*type == "reset") {
        message = ResetMessage{};
    } else if (*type == "demo") {
        message = DemoMessage{keys.integer("place", -1)};
    } else if (*type == "model") {
        message = ModelMessage{keys.integer("model", 0)};
    } else
        throw Wrong{"'type' must be one of pointer, pause, reset, demo, model"};
    keys.no_more();
    return message;
}

}  // namespace

std::variant<Message, Refusal> parse_message(std::string_view text) {
    if (text.size() > longest_message) return Refusal{"too_long", fmt::format("a message longer than {} bytes", longest_message)};
    const Json j = Json::parse(text, nullptr, false);
    if (j.is_discarded()) return Refusal{"message", "not JSON"};
    try {
        return read(j);
    } catch (const Wrong& wrong) {
        return Refusal{"message", wrong.reason};
    }
}

std::string bye_message(const std::string& reason) {
    return Json{{"type", "bye"}, {"reason", reason}}.dump();
}

std::string near_message(int place, double distance_m, const std::vector<FeOutline>& outlines) {
    const auto rounded = [](double u_m) { return std::round(1e7 * u_m) / 1e7 + 0.0; };  // fewer digits, and no -0
    Json outline = Json::array();
    for (const FeOutline& o : outlines) {
        Json moved = Json::array();
        for (const auto& u : o.displacement_m.rowwise()) {
            Json node = Json::array();
            for (double along : u) node.push_back(rounded(along));
            moved.push_back(node);
        }
        outline.push_back({o.depth_m, moved});
    }
    return Json{{"type", "near"}, {"place", place}, {"distance_m", distance_m}, {"outline", outline}}.dump();
}

std::string control_message(const char* holder, const std::vector<const char*>& holders, bool paused, int place) {
    return Json{{"type", "control"}, {"holder", holder}, {"holders", holders}, {"paused", paused}, {"place", place}}.dump();
}

}  // namespace tissue::serve
