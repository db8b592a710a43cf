#include "study/toml_reader.h"

#include <catch2/catch.hpp>
#include <random>

#include "error.h"
#include "../example.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

TEST_CASE("invalid TOML is refused with file and line even where toml++ would fail an assertion") {
    const auto said = [](const std::string& wrong) {
        return refusal<StudyError>([&] { parse_toml("a = 1\n\n" + wrong + "\nb = 2\n", "s.toml"); });
    };
    for (const char* wrong : {"[,x]", "[[.]]", "[\\u]", "[[", "[#", "c = {,}", "c = { d = ,", "c = [1 }", "c = = 1", "c", "c = \"",
                              "c = 1e", "c = 0x", "c = 1979-99-99", "[a]\n[a", "\"c = 1", "c = '''", "c.= 1", "=", "c = [1,,2]",
                              "c = 1\xc3\xa9", "c = [1\xe3\x80\x81 2]", "c = 1\xef\xbc\x81", "\xc3\xa9 = 1"}) {
        INFO(wrong);
        CHECK_THAT(said(wrong), StartsWith("s.toml:"));
    }
    CHECK_THAT(said("[,x]"), StartsWith("s.toml:3: "));
    CHECK_THAT(said("c = { d = ,"), StartsWith("s.toml:3: "));
}

TEST_CASE("an overlong key and deep nesting are refused before they exhaust the stack") {
    std::string key = "a";
    for (int i = 0; i < 200000; ++i) key += ".a";
    for (const std::string& text : {key + " = 1", "[" + key + "]", "b = { " + key + " = 1 }"})
        CHECK_THAT(refusal<StudyError>([&] { parse_toml("b = 1\n" + text, "s.toml"); }), StartsWith("s.toml:2: ") && Contains("characters"));
    CHECK_THAT(refusal<StudyError>([&] { parse_toml("b = " + std::string(5000, '['), "s.toml"); }), StartsWith("s.toml:1: "));
}

TEST_CASE("a study text with random insertions and deletions is read or refused in one line") {
    const std::vector<std::string> bits = {"[", "]", "{", "}", "=", ",", "\"", "'", "\"\"\"", "'''", "\n", ".", "..", "0x", "1e", "+", "-",
                                           "_", "#", "\\", "\\u", "\xff", "\xc3", std::string(1, '\0'), "inf", "nan", "true",
                                           "1979-05-27", "07:32:00", "[[", "]]", "a.b", "\r", "\t", "\x7f", "\xef\xbb\xbf",
                                           "\xe2\x80\xa8", "\\U0010ffff", "99999999999999999999", "1e999", "{a=1,}", "[1,[2"};
    const TemporaryFolder folder;
    std::mt19937 draw(2008);
    int refused = 0;
    for (int k = 0; k < 4000; ++k) {
        std::string text = example_study_text();
        for (int changes = 1 + static_cast<int>(draw() % 3); changes > 0; --changes) {
            const std::size_t at = draw() % text.size();
            if (draw() % 3 == 0) text.erase(at, 1 + draw() % 30);
            text.insert(std::min(at, text.size()), bits[draw() % bits.size()]);
        }
        INFO(text);
        try {
            read_study(folder.file("s.toml", text));
        } catch (const Error& e) {
            ++refused;
            CHECK(std::string(e.what()).find('\n') == std::string::npos);
        }
    }
    CHECK(refused > 3000);
}
