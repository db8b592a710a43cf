#include "page.h"

#include <cstddef>

// The assembler takes the files in; paths are the project's, from which make runs.
#define TAKE_IN(name, file)                                                                               \
    __asm__(".section .rodata\n" #name "_begin:\n.incbin \"" file "\"\n" #name "_end:\n.byte 0\n.previous\n"); \
    extern "C" const char name##_begin[], name##_end[];

TAKE_IN(view_index, "cli/view/index.html")
TAKE_IN(view_style, "cli/view/page.css")
TAKE_IN(view_script, "cli/view/page.js")

namespace tissue::serve {
namespace {

std::string_view between(const char* begin, const char* end) {
    return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

const PageFile* page_file(std::string_view path) {
    static const PageFile files[] = {
        {"/", "text/html; charset=utf-8", between(view_index_begin, view_index_end)},
        {"/page.css", "text/css; charset=utf-8", between(view_style_begin, view_style_end)},
        {"/page.js", "text/javascript; charset=utf-8", between(view_script_begin, view_script_end)},
    };
    for (const PageFile& file : files)
        if (file.path == path) return &file;
    return nullptr;
}

}  // namespace tissue::serve
