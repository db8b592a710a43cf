#include "io/dataset_name.h"

#include <algorithm>

namespace tissue {

bool can_name_a_dataset(const std::string& text) {
    const bool plain = std::none_of(text.begin(), text.end(), [](char c) { return c == '/' || (c >= 0 && c < ' ') || c == 127; });
    return plain && !text.empty() && text != "." && text != "..";
}

}  // namespace tissue
