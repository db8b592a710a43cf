#pragma once

#include <string_view>
#include <vector>

namespace tissue::serve {

/// A file of the page (cli/view), embedded in the program when it was built.
struct PageFile {
    std::string_view path, type, text;
};

const std::vector<PageFile>& page_files();

/// The file of a request's path; nullptr: there is none.
const PageFile* page_file(std::string_view path);

}  // namespace tissue::serve
