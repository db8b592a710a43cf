#include <catch2/catch.hpp>

#include "io/one_line.h"

using tissue::one_line;

TEST_CASE("one_line escapes control characters and C1 codes in UTF-8 and bytes that are not UTF-8", "[study]") {
    CHECK(one_line("plain: 5 % of [a, b]\\n") == "plain: 5 % of [a, b]\\n");
    CHECK(one_line("a\nb\tc\r\x1b[31m\x07\x7f") == "a\\x0ab\\x09c\\x0d\\x1b[31m\\x07\\x7f");
    CHECK(one_line(std::string("a\0b", 3)) == "a\\x00b");
    CHECK(one_line("Gr\xc3\xb6\xc3\x9f" "e \xe2\x82\xac \xf0\x9f\xab\x81") == "Gr\xc3\xb6\xc3\x9f" "e \xe2\x82\xac \xf0\x9f\xab\x81");
    CHECK(one_line("\xc2\x9b" "31m \xc2\xa0") == "\\xc2\\x9b31m \xc2\xa0");  // 8-bit CSI; a no-break space stays
    CHECK(one_line("\x9b" "31m Gr\xf6\xdf" "e \xe2\x82") == "\\x9b31m Gr\\xf6\\xdfe \\xe2\\x82");
    CHECK(one_line(one_line("\x1b]0;title\x07")) == one_line("\x1b]0;title\x07"));
}
