#pragma once

#include <string_view>
#include <vector>

namespace tissue::serve {

/// A file of the page (cli/view), as it was when the program was built.
struct PageFile {
    std::string_view path, type, text;
};

/// All of them.
const std::vector<PageFile>& page_files();

/// By the path of a request; nullptr when there is none.
const PageFile* page_file(std::string_view path);

}  // namespace tissue::serve
