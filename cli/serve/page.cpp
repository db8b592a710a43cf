#include "page.h"

#include <cstddef>

// The assembler embeds the files. Paths are relative to the project's root, where make runs; three.js is in Debian's
// libjs-three.
#define TAKE_IN(name, file)                                                                                    \
    __asm__(".section .rodata\n" #name "_begin:\n.incbin \"" file "\"\n" #name "_end:\n.byte 0\n.previous\n"); \
    extern "C" const char name##_begin[], name##_end[];

#define VIEW_FILES(DO)                                      \
    DO(index, "/", "index.html", html)                      \
    DO(style, "/page.css", "page.css", css)                 \
    DO(page, "/page.js", "page.js", javascript)             \
    DO(branches, "/branches.js", "branches.js", javascript) \
    DO(canvas, "/canvas.js", "canvas.js", javascript)       \
    DO(carried, "/carried.js", "carried.js", javascript)    \
    DO(compare, "/compare.js", "compare.js", javascript)    \
    DO(controls, "/controls.js", "controls.js", javascript) \
    DO(errors, "/errors.js", "errors.js", javascript)       \
    DO(faces, "/faces.js", "faces.js", javascript)          \
    DO(follow, "/follow.js", "follow.js", javascript)       \
    DO(hand, "/hand.js", "hand.js", javascript)             \
    DO(learned, "/learned.js", "learned.js", javascript)    \
    DO(legend, "/legend.js", "legend.js", javascript)       \
    DO(nodule, "/nodule.js", "nodule.js", javascript)       \
    DO(numbers, "/numbers.js", "numbers.js", javascript)    \
    DO(places, "/places.js", "places.js", javascript)       \
    DO(plane, "/plane.js", "plane.js", javascript)          \
    DO(plane_hand, "/plane_hand.js", "plane_hand.js", javascript) \
    DO(plots, "/plots.js", "plots.js", javascript)          \
    DO(rest, "/rest.js", "rest.js", javascript)             \
    DO(scale, "/scale.js", "scale.js", javascript)          \
    DO(snap, "/snap.js", "snap.js", javascript)             \
    DO(space, "/space.js", "space.js", javascript)          \
    DO(space_hand, "/space_hand.js", "space_hand.js", javascript) \
    DO(state, "/state.js", "state.js", javascript)          \
    DO(surface, "/surface.js", "surface.js", javascript)    \
    DO(transport, "/transport.js", "transport.js", javascript) \
    DO(vectors, "/vectors.js", "vectors.js", javascript)    \
    DO(words, "/words.js", "words.js", javascript)

#define TAKE_IN_VIEW(name, path, file, type) TAKE_IN(view_##name, "cli/view/" file)
VIEW_FILES(TAKE_IN_VIEW)
TAKE_IN(view_three, "/usr/share/javascript/three/three.module.js")

namespace tissue::serve {
namespace {

std::string_view between(const char* begin, const char* end) {
    return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

const std::vector<PageFile>& page_files() {
#define VIEW_FILE(name, path, file, type) {path, "text/" #type "; charset=utf-8", between(view_##name##_begin, view_##name##_end)},
    static const std::vector<PageFile> files = {
        VIEW_FILES(VIEW_FILE)
        {"/three.module.js", "text/javascript; charset=utf-8", between(view_three_begin, view_three_end)}};
    return files;
}

const PageFile* page_file(std::string_view path) {
    for (const PageFile& file : page_files())
        if (file.path == path) return &file;
    return nullptr;
}

}  // namespace tissue::serve
