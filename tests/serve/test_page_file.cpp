#include <catch2/catch.hpp>
#include <string>

#include "../../cli/serve/page.h"

using namespace tissue::serve;

TEST_CASE("the program contains the complete page and the page refers to no other site", "[serve]") {
    CHECK(page_file("/page.css"));
    CHECK(page_file("/page.js"));
    for (const PageFile& file : page_files()) {
        INFO(file.path);
        CHECK(file.text.size() > 200);
        CHECK(page_file(file.path)->text == file.text);
        if (file.path != "/three.module.js") CHECK(file.text.find("https://") == std::string_view::npos);
        const std::string_view from = " from \"./";   // every module that is imported statically is in the program
        for (std::size_t at = 0; (at = file.text.find(from, at)) != std::string_view::npos;) {
            at += from.size() - 1;
            const std::string needed(file.text.substr(at, file.text.find('"', at) - at));
            INFO(needed);
            CHECK(page_file(needed));
        }
    }
    CHECK(page_file("/")->text.find("</html>") != std::string_view::npos);
    // the content security policy forbids inline scripts
    CHECK(page_file("/")->text.find("<script>") == std::string_view::npos);
    CHECK_FALSE(page_file("/index.html/.."));
    CHECK_FALSE(page_file(""));
}
