#pragma once

#include <string>
#include <utility>
#include <vector>

#include "error.h"

namespace tissue {

/// The kinds of one thing, in the order in which messages list them. Each kind knows its own name, and is entered in one
/// line.
template <class Kind>
class Registry {
   public:
    /// what: the thing, as messages call it ("spring law"). name_of(kind): its name.
    template <class NameOf>
    Registry(std::string what, std::vector<Kind> kinds, NameOf name_of) : what_(std::move(what)), kinds_(std::move(kinds)) {
        for (const Kind& kind : kinds_) names_.push_back(name_of(kind));
    }

    const std::vector<Kind>& kinds() const { return kinds_; }
    const std::vector<std::string>& names() const { return names_; }

    /// Throws MismatchError for an unknown name, listing what is allowed.
    const Kind& at(const std::string& name) const {
        std::string allowed;
        for (std::size_t i = 0; i < names_.size(); ++i) {
            if (names_[i] == name) return kinds_[i];
            allowed += (i == 0 ? "" : ", ") + names_[i];
        }
        throw MismatchError(what_ + " '" + name + "' is not known; allowed: " + allowed);
    }

   private:
    std::string what_;
    std::vector<Kind> kinds_;
    std::vector<std::string> names_;
};

}  // namespace tissue
