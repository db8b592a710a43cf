#include "cases/measured_csv.h"

#include <catch2/catch.hpp>

#include "../example.h"
#include "../refusal.h"
#include "../tolerances.h"
#include "error.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const std::string header =
    "contact_x [mm],contact_y [mm],displacement_x [mm],displacement_y [mm],force_x [mN],force_y [mN]\n";
const std::string rows = "0,50,5,0,12,0.5\n100,50,-5,0,-11,0.5\n";

MeasuredTable table_of(const std::string& text) {
    const TemporaryFolder folder;
    return read_measured_csv(folder.file("data.csv", text));
}

/// Refusal of a text; it must name file and line.
std::string refused(const std::string& text, int line) {
    const std::string said = refusal<FileError>([&] { table_of(text); });
    CHECK_THAT(said, Contains("data.csv:" + std::to_string(line) + ": "));
    return said;
}

}  // namespace

TEST_CASE("measured rows are converted to SI units for any units and column order of the header", "[measured]") {
    const MeasuredTable mm = table_of("# by hand\n# on a Monday\n" + header + rows);
    REQUIRE(mm.rows.size() == 2);
    CHECK(mm.origin == "by hand on a Monday");
    CHECK(mm.rows[0].line == 4);
    CHECK(mm.rows[0].contact_m.isApprox(Eigen::Vector2d(0, 0.05), tolerance::rounding));
    CHECK(mm.rows[0].displacement_m.isApprox(Eigen::Vector2d(0.005, 0), tolerance::rounding));
    CHECK(mm.rows[0].force_N.isApprox(Eigen::Vector2d(0.012, 0.0005), tolerance::rounding));
    const MeasuredTable m = table_of(
        "force_y [N],force_x [N],role,contact_x [m], contact_y [m] ,displacement_x [mm],displacement_y [m]\r\n"
        "0.0005,0.012,train,0,0.05,5,0\r\n\n");
    REQUIRE(m.rows.size() == 1);
    CHECK(m.rows[0].role == "train");
    CHECK(m.rows[0].contact_m.isApprox(mm.rows[0].contact_m, tolerance::rounding));
    CHECK(m.rows[0].displacement_m.isApprox(mm.rows[0].displacement_m, tolerance::rounding));
    CHECK(m.rows[0].force_N.isApprox(mm.rows[0].force_N, tolerance::rounding));
}

TEST_CASE("a measurement header with a wrong unit or column is refused by column", "[measured]") {
    CHECK_THAT(refused(with(header, "force_x [mN]", "force_x"), 1), Contains("'force_x'") && Contains("no unit") && Contains("N, mN"));
    CHECK_THAT(refused(with(header, "contact_x [mm]", "contact_x [inch]"), 1), Contains("'contact_x'") && Contains("'inch'") && Contains("m, mm"));
    CHECK_THAT(refused(with(header, "force_y [mN]", "force_y [mm]"), 1), Contains("'force_y'") && Contains("'mm'"));
    CHECK_THAT(refused(with(header, "force_y [mN]", "force_y [mN"), 1), Contains("'force_y'"));
    CHECK_THAT(refused(with(header, "force_y [mN]", "force_z [mN]"), 1), Contains("'force_z' is not known"));
    CHECK_THAT(refused(with(header, ",force_y [mN]", ""), 1), Contains("'force_y' is missing"));
    CHECK_THAT(refused(with(header, "force_y [mN]", "force_x [mN]"), 1), Contains("'force_x' is present twice"));
    CHECK_THAT(refused(with(header, "force_y [mN]", "force_y [mN],role [mm]"), 1), Contains("'role'"));
}

TEST_CASE("an invalid measurement row is refused by line and column", "[measured]") {
    const auto last = [](const std::string& row) { return refused(header + rows + row + "\n", 4); };
    CHECK_THAT(last("0,50,nan,0,12,1"), Contains("'displacement_x'") && Contains("'nan'"));
    CHECK_THAT(last("0,50,5,0,inf,1"), Contains("'force_x'"));
    CHECK_THAT(last("0,50,5,0,12 mN,1"), Contains("'force_x'") && Contains("12 mN"));
    CHECK_THAT(last("0,50,5,0,,1"), Contains("'force_x'"));
    CHECK_THAT(last("0,50,5,0,12"), Contains("5 fields") && Contains("6 columns"));
    CHECK_THAT(last("0,50,0,0,12,1"), Contains("'displacement_x'") && Contains("zero"));
    CHECK_THAT(last("0,50,5,0,0,0"), Contains("'force_x'") && Contains("zero"));
    CHECK_THAT(last("0,50,5,0,12,0.5"), Contains("the same as line 2"));
    CHECK_THAT(refused(with(header, "force_y [mN]", "force_y [mN],role") + "0,50,5,0,12,0.5,test\n", 2),
               Contains("'role'") && Contains("'test'") && Contains("held_out"));
    CHECK_THAT(refused(with(header, "force_y [mN]", "force_y [mN],push") + "0,50,5,0,12,0.5, \n", 2), Contains("'push' is empty"));
    for (const std::string& nothing : {std::string(), std::string("# origin\n"), header})
        CHECK_THROWS_AS(table_of(nothing), FileError);
    CHECK_THROWS_AS(read_measured_csv("/nowhere/data.csv"), FileError);
}
