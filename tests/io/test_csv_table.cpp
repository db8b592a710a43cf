#include "io/csv_table.h"

#include <catch2/catch.hpp>

#include "../example.h"
#include "../refusal.h"
#include "error.h"
#include "io/csv_columns.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// All rows of a CSV text.
std::vector<std::vector<std::string>> rows_of(const std::string& text) {
    std::istringstream in(text);
    CsvTable table(in, "data.csv");
    std::vector<std::vector<std::string>> rows;
    while (table.next()) {
        rows.emplace_back();
        for (std::size_t i = 0; i < table.size(); ++i) rows.back().push_back(table.field(i));
    }
    return rows;
}

std::string refused(const std::string& text) {
    return refusal<FileError>([&] { rows_of(text); });
}

/// The second row's second field as a number.
double number_in(const std::string& text) {
    std::istringstream in(text);
    CsvTable table(in, "data.csv");
    REQUIRE(table.next());
    REQUIRE(table.next());
    return table.number(1, "b");
}

}  // namespace

TEST_CASE("a CSV table is read equally with any separator or line end or quotes or blank lines", "[csv]") {
    const std::vector<std::vector<std::string>> rows = {{"a [mm]", "b"}, {"1", "-2.5"}};
    for (const std::string text :
         {"a [mm],b\n1,-2.5\n", "\xef\xbb\xbf" "a [mm],b\r\n1,-2.5\r\n", "a [mm],b\r1,-2.5", "a [mm];b\n1;-2.5", "a [mm]\tb\n1\t-2.5\n", "\"a [mm]\",\"b\"\n\"1\",-2.5\n",
          "a [mm], b\n1, -2.5\n\n", "\n  \na [mm] ; b\n1 ;-2.5\n"}) {
        INFO(text);
        CHECK(rows_of(text) == rows);
    }
    CHECK(rows_of("a,\"b, c\"\n1,\"say \"\"2\"\"\"\n") == std::vector<std::vector<std::string>>{{"a", "b, c"}, {"1", "say \"2\""}});
    CHECK(rows_of("a,b,\n1,2,\n3,4,,\n5,6\n7,8,9\n") == std::vector<std::vector<std::string>>{{"a", "b"}, {"1", "2"}, {"3", "4"}, {"5", "6"}, {"7", "8", "9"}});
    CHECK(rows_of("a,b\n,\n1,") == std::vector<std::vector<std::string>>{{"a", "b"}, {"", ""}, {"1", ""}});
}

TEST_CASE("line numbers of a CSV include comments and blank lines for all line ends", "[csv]") {
    for (const std::string end : {"\n", "\r\n", "\r"}) {
        std::istringstream in("# made by \"hand" + end + end + "a,b" + end + "1,2");
        CsvTable table(in, "data.csv");
        REQUIRE(table.next());
        CHECK(table.is_comment());
        REQUIRE(table.next());
        CHECK(table.number() == 3);
        REQUIRE(table.next());
        CHECK(table.number() == 4);
        CHECK_FALSE(table.next());
    }
}

TEST_CASE("another encoding than UTF-8 is refused with the cause", "[csv]") {
    CHECK_THAT(refused("a,b\n# 20 \xb0" "C\n1,2\n"), Contains("data.csv:2: ") && Contains("0xb0") && Contains("not UTF-8") && Contains("save the file as UTF-8"));
    CHECK_THAT(refused(std::string("\xff\xfe" "a\0,\0b\0\n\0", 10)), Contains("data.csv:1: ") && Contains("UTF-16"));
    CHECK_THAT(refused(std::string("\0a\0,\0b\0\n", 8)), Contains("UTF-16"));
    CHECK_THAT(refused("PK\x03\x04 and so on"), Contains("spreadsheet"));
    CHECK(rows_of("# 20 \xc2\xb0" "C, \xc2\xb5m\na,b\n").size() == 2);
}

TEST_CASE("an unclosed or misplaced quote is refused with its line", "[csv]") {
    CHECK_THAT(refused("a,b\n\"1,2\n"), Contains("data.csv:2: ") && Contains("quote"));
    CHECK_THAT(refused("a,b\n1 \"mm\",2\n"), Contains("data.csv:2: ") && Contains("quote"));
}

TEST_CASE("a decimal comma is refused with advice; blanks around a number are ignored", "[csv]") {
    CHECK(number_in("a;b\n1; 2.5e-3 \n") == 2.5e-3);
    CHECK_THAT(refusal<FileError>([] { number_in("a;b\n1;2,5\n"); }), Contains("data.csv:2: ") && Contains("'2,5'") && Contains("write a decimal point"));
    CHECK(number_in("a;b\n1;+2\n") == 2);
    CHECK(number_in("a;b\n1;\" 20.0 \"\n") == 20);
    for (const char* none : {"+-2", "++2", "+", "", "1 000", "0x10", "1e400", "inf"})
        CHECK_THAT(refusal<FileError>([&] { number_in(std::string("a;b\n1;") + none); }), Contains("not a finite number"));
    std::istringstream in("a [mm],b [mm]\n1,5,2,5\n");
    CsvTable table(in, "data.csv");
    REQUIRE(table.next());
    const CsvColumns columns(table, {{"a", &length_units(), true}, {"b", &length_units(), true}});
    REQUIRE(table.next());
    CHECK_THAT(refusal<FileError>([&] { columns.check(table); }), Contains("has 4 fields") && Contains("decimal commas"));
}

TEST_CASE("a CSV line with more than 256 fields or 1048576 bytes is refused", "[csv]") {
    CHECK_THAT(refused(std::string(100'000, ',')), Contains("more than 256 fields"));
    CHECK_THAT(refused(std::string(20 << 20, ',')), Contains("more than 1048576 bytes"));
    std::istringstream in(std::string(100'000, ','));
    CsvLines lines(in, "left.csv");
    CHECK_THAT(refusal<FileError>([&] { lines.next(); }), Contains("more than 256 fields"));
}
