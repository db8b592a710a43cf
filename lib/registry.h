#pragma once

#include <string>
#include <utility>
#include <vector>

#include "error.h"

namespace tissue {

/// All kinds of one thing (devices, spring laws), in the order in which messages list them. The name of a kind is read
/// from the kind itself, so that a new kind is one entry in the list.
template <class Kind>
class Registry {
   public:
    /// what: the thing's name in messages ("spring law"). kinds: all of them. name_of(kind): the name of a kind.
    template <class NameOf>
    Registry(std::string what, std::vector<Kind> kinds, NameOf name_of) : what_(std::move(what)), kinds_(std::move(kinds)) {
        for (const Kind& kind : kinds_) names_.push_back(name_of(kind));
    }

    const std::vector<Kind>& kinds() const { return kinds_; }
    const std::vector<std::string>& names() const { return names_; }

    /// The kind of this name. Throws MismatchError for an unknown name; the message lists the allowed names.
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
