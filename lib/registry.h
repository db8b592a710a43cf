#pragma once

#include <string>
#include <utility>
#include <vector>

#include "error.h"

namespace tissue {

/// The kinds of one thing by name: each named once, in one line, in the order in which messages list them.
template <class Kind>
class Registry {
   public:
    /// what: the thing, as messages call it ("spring law").
    Registry(std::string what, std::vector<std::pair<std::string, Kind>> kinds)
        : what_(std::move(what)), kinds_(std::move(kinds)) {}

    const std::vector<std::pair<std::string, Kind>>& kinds() const { return kinds_; }

    std::vector<std::string> names() const {
        std::vector<std::string> names;
        for (const auto& [name, kind] : kinds_) names.push_back(name);
        return names;
    }

    /// Throws MismatchError for an unknown name, listing what is allowed.
    const Kind& at(const std::string& name) const {
        std::string allowed;
        for (const auto& [known, kind] : kinds_) {
            if (known == name) return kind;
            allowed += (allowed.empty() ? "" : ", ") + known;
        }
        throw MismatchError(what_ + " '" + name + "' is not known; allowed: " + allowed);
    }

   private:
    std::string what_;
    std::vector<std::pair<std::string, Kind>> kinds_;
};

}  // namespace tissue
