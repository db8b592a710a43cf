#include "io/hdf5_store.h"

#include <hdf5.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>

#include "error.h"
#include "../format_version.h"
#include "../example.h"
#include "io/atomic_file.h"
#include "../refusal.h"
#include "version.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const Provenance provenance{"tissuectl test", 4294967295UL, {{"in.csv", "00ff"}}};

/// Numbers that a conversion to text or float would change.
const std::vector<double>& odd_numbers() {
    static const std::vector<double> values = {0.1,
                                               -0.0,
                                               5e-324,
                                               std::numeric_limits<double>::max(),
                                               1 + std::numeric_limits<double>::epsilon(),
                                               std::nan(""),
                                               std::numeric_limits<double>::infinity()};
    return values;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// Writes a small complete file of this project.
std::string example_file(const TemporaryFolder& folder, const std::string& kind = "cases") {
    const std::string file = folder.file("a.h5");
    Hdf5Writer out(file, kind, provenance);
    out.write("/group/numbers", Array{{odd_numbers().size()}, odd_numbers()}, "N", "odd numbers");
    out.write_texts("/group/words", {"left", "", "\xc3\xa4"}, "words");
    out.write_integers("/group/counts", {2, 2}, {1, -2, 3, 2147483647}, "counts");
    out.commit();
    return file;
}

/// The whole content of a file of this project, for comparison. Throws FileError if it is refused.
std::string everything(const std::string& file) {
    const Hdf5Reader in(file, "");
    std::string all = in.text_attribute("/", "command") + in.text_attribute("/", "kind") + in.text_attribute("/", "input:in.csv") +
                      std::to_string(in.number_attribute("/", "seed")) + std::to_string(in.number_attribute("/", "format_version"));
    for (const std::string& line : in.describe()) all += line + '\n';
    for (const std::string& name : in.datasets()) {
        if (in.kind(name) == DatasetKind::texts) {
            for (const std::string& text : in.texts(name)) all += text + '\n';
            continue;
        }
        const Array a = in.array(name);
        all.append(reinterpret_cast<const char*>(a.values.data()), a.values.size() * sizeof(double));
    }
    return all;
}

}  // namespace

TEST_CASE("arrays are read back with the same shape and the same bits") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.h5");
    const Array cube{{2, 3, 4}, [] {
                         std::vector<double> v;
                         for (int i = 0; i < 24; ++i) v.push_back(std::sin(i));
                         return v;
                     }()};
    NodeField field(3, 2);
    field << 1, 2, 3, 4, 5, 6;
    const Eigen::VectorXd vector = Eigen::VectorXd::LinSpaced(5, 0.1, 0.7);
    {
        Hdf5Writer out(file, "cases", provenance);
        out.write("/a/b/cube", cube, "m", "a cube");
        out.write("/odd", Array{{odd_numbers().size()}, odd_numbers()}, "N", "odd numbers");
        out.write("/field", field, "m", "a field (N x D)");
        out.write("/vector", vector, "1", "a vector");
        out.write("/empty", Array{{0}, {}}, "1", "nothing");
        out.commit();
    }
    const Hdf5Reader in(file, "cases");
    CHECK(in.array("/a/b/cube").shape == cube.shape);
    CHECK(same_bits(in.array("/a/b/cube").values, cube.values));
    CHECK(same_bits(in.array("/odd").values, odd_numbers()));
    CHECK(in.field("/field") == field);
    CHECK(in.vector("/vector") == vector);
    CHECK(in.array("/empty").values.empty());
}

TEST_CASE("rows appended in pieces of any size are read back as one dataset") {
    const TemporaryFolder folder;
    NodeField field(5000, 3);
    std::vector<int> counts;
    for (int i = 0; i < 5000; ++i) {
        for (int a = 0; a < 3; ++a) field(i, a) = std::sin(3 * i + a);
        counts.push_back(i - 7);
    }
    {
        Hdf5Writer out(folder.file("a.h5"), "recording", provenance);
        out.begin_rows("/field", 3, "m", "a field (R x 3)");
        out.begin_rows("/time", 0, "s", "a list");
        out.begin_rows("/counts", 0, "", "whole numbers");
        out.begin_rows("/none", 2, "N", "nothing came");
        int row = 0;
        for (int piece : {1, 1023, 1024, 0, 2000, 952}) {
            out.append_rows("/field", std::vector<double>(field.data() + 3 * row, field.data() + 3 * (row + piece)));
            out.append_rows("/time", std::vector<double>(static_cast<std::size_t>(piece), 0.5 * row));
            out.append_rows("/counts", std::vector<int>(counts.begin() + row, counts.begin() + row + piece));
            row += piece;
        }
        REQUIRE(row == 5000);
        CHECK_THAT(refusal<FileError>([&] { out.append_rows("/other", std::vector<int>{1}); }), Contains("/other"));
        CHECK_THAT(refusal<FileError>([&] { out.begin_rows("/field", 3, "m", "again"); }), Contains("/field"));
        out.commit();
    }
    const Hdf5Reader in(folder.file("a.h5"), "recording");
    CHECK(in.field("/field") == field);
    CHECK(in.integers("/counts") == counts);
    CHECK(in.vector("/time").size() == 5000);
    CHECK(in.vector("/time")[4999] == 0.5 * 4048);
    CHECK(in.array("/none").shape == std::vector<std::size_t>{0, 2});
    CHECK(in.text_attribute("/field", "units") == "m");
    CHECK(in.text_attribute("/counts", "units") == "1");
}

TEST_CASE("integers and texts are read back unchanged") {
    const TemporaryFolder folder;
    const Hdf5Reader in(example_file(folder), "cases");
    CHECK(in.integers("/group/counts") == std::vector<int>{1, -2, 3, 2147483647});
    CHECK(in.texts("/group/words") == std::vector<std::string>{"left", "", "\xc3\xa4"});
    CHECK(in.children("/group") == std::vector<std::string>{"counts", "numbers", "words"});
}

TEST_CASE("an HDF5 file contains its program, kind, format, version, command, seed and input hashes") {
    const TemporaryFolder folder;
    const Hdf5Reader in(example_file(folder), "cases");
    CHECK(in.text_attribute("/", "program") == "tissuectl");
    CHECK(in.text_attribute("/", "kind") == "cases");
    CHECK(in.number_attribute("/", "format_version") == format_version);
    CHECK(in.text_attribute("/", "version") == version);
    CHECK(in.text_attribute("/", "command") == "tissuectl test");
    CHECK(in.number_attribute("/", "seed") == 4294967295.0);
    CHECK(in.text_attribute("/", "input:in.csv") == "00ff");
}

TEST_CASE("every dataset has its units and a description") {
    const TemporaryFolder folder;
    const Hdf5Reader in(example_file(folder), "");
    CHECK(in.text_attribute("/group/numbers", "units") == "N");
    CHECK(in.text_attribute("/group/numbers", "description") == "odd numbers");
    CHECK(in.text_attribute("/group/counts", "units") == "1");
    const std::vector<std::string> lines = in.describe();
    REQUIRE(lines.size() == 3);
    CHECK_THAT(lines[0], Contains("/group/counts") && Contains("2 x 2") && Contains("counts"));
}

TEST_CASE("the same contents make the same file byte for byte; no time is stored") {
    const TemporaryFolder one, other;
    CHECK(file_hash(example_file(one)) == file_hash(example_file(other)));
    const hid_t id = H5Fopen(one.file("a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    for (const char* dataset : {"/group/numbers", "/group/words", "/group/counts"}) {
        H5O_info_t info;
        REQUIRE(H5Oget_info_by_name(id, dataset, &info, H5P_DEFAULT) >= 0);
        CHECK(info.ctime == 0);  // no time is stored
    }
    H5Fclose(id);
}

TEST_CASE("a file appears at commit; without it the old file stays and no temporary file remains") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.h5", "earlier results");
    {
        Hdf5Writer out(file, "cases", provenance);
        out.write("/x", Array{{1}, {1}}, "1", "x");
        CHECK(read_file(file) == "earlier results");
    }
    CHECK(read_file(file) == "earlier results");
    CHECK(folder.names() == std::vector<std::string>{"a.h5"});
    Hdf5Writer out(file, "cases", provenance);
    out.commit();
    CHECK(folder.names() == std::vector<std::string>{"a.h5"});
    CHECK(Hdf5Reader(file, "cases").file() == file);
}

TEST_CASE("a file that is missing, empty, foreign or a folder is refused by name") {
    const TemporaryFolder folder;
    const auto said = [](const std::string& file) { return refusal<FileError>([&] { Hdf5Reader(file, "cases"); }); };
    CHECK_THAT(said(folder.file("none.h5")), Contains("none.h5") && Contains("no such file"));
    CHECK_THAT(said(folder.file("empty.h5", "")), Contains("empty.h5") && Contains("not an HDF5 file"));
    CHECK_THAT(said(folder.file("text.h5", "not a file of ours\n")), Contains("text.h5") && Contains("not an HDF5 file"));
    CHECK_THAT(said(folder.file("")), Contains("is a folder; give a file"));

    const std::string foreign = folder.file("foreign.h5");
    H5Fclose(H5Fcreate(foreign.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
    CHECK_THAT(said(foreign), Contains("foreign.h5") && Contains("not written by tissuectl"));
}

TEST_CASE("a truncated HDF5 file is refused") {
    const TemporaryFolder folder;
    const std::string whole = read_file(example_file(folder));
    for (const double part : {0.01, 0.3, 0.6, 0.9}) {
        const auto size = static_cast<std::size_t>(part * static_cast<double>(whole.size()));
        const std::string file = folder.file("cut.h5", whole.substr(0, size));
        CHECK_THAT(refusal<FileError>([&] { Hdf5Reader(file, "cases"); }), Contains("cut.h5") && Contains("truncated"));
    }
    const std::string file = folder.file("cut.h5", whole.substr(0, whole.size() - 1));
    CHECK_THROWS_AS(Hdf5Reader(file, "cases"), FileError);
}

TEST_CASE("a flipped bit in a file is detected or changes nothing that is read") {
    const TemporaryFolder folder;
    const std::string file = example_file(folder), flipped = folder.file("flipped.h5"), whole = read_file(file), wanted = everything(file);
    int found = 0, harmless = 0;
    std::mt19937 draw(1);
    for (std::size_t byte = draw() % 3; byte < whole.size(); byte += 1 + draw() % 3) {
        std::string bytes = whole;
        bytes[byte] = static_cast<char>(bytes[byte] ^ (1 << draw() % 8));
        std::ofstream(flipped, std::ios::binary) << bytes;
        INFO("byte " << byte);
        std::string seen;
        try {
            seen = everything(flipped);
        } catch (const FileError&) {
            ++found;
            continue;
        }
        REQUIRE(seen == wanted);
        ++harmless;  // unused bytes between the objects
    }
    CAPTURE(found, harmless);
    CHECK(found > 300);
}

TEST_CASE("a dataset that claims more values than its file can hold is refused") {
    const TemporaryFolder folder;
    const std::string file = example_file(folder);
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const hsize_t many = hsize_t{1} << 31;
    const hid_t space = H5Screate_simple(1, &many, nullptr), creation = H5Pcreate(H5P_DATASET_CREATE), text = H5Tcopy(H5T_C_S1);
    const hsize_t piece = 1024;
    H5Pset_chunk(creation, 1, &piece);
    H5Tset_size(text, 16);
    H5Dclose(H5Dcreate2(id, "/claims", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Dclose(H5Dcreate2(id, "/says", text, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Tclose(text);
    H5Pclose(creation);
    H5Sclose(space);
    H5Fclose(id);
    const Hdf5Reader in(file, "");
    CHECK_THAT(refusal<FileError>([&] { in.array("/claims"); }), Contains("/claims: declares more values than the file can contain"));
    CHECK_THAT(refusal<FileError>([&] { in.texts("/says"); }), Contains("/says: declares more values than the file can contain"));
}

TEST_CASE("a scalar dataset and an empty one are read back unchanged") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.h5");
    {
        Hdf5Writer out(file, "cases", provenance);
        out.write("/one", Array{{}, {0.1}}, "m", "");
        out.write("/none", Array{{0, 3}, {}}, "m", "");
        out.commit();
    }
    const Hdf5Reader in(file, "cases");
    CHECK(in.array("/one").shape.empty());
    CHECK(in.array("/one").values == std::vector<double>{0.1});
    CHECK(in.array("/none").shape == std::vector<std::size_t>{0, 3});
    CHECK(in.array("/none").values.empty());
}

TEST_CASE("control characters and invalid UTF-8 in texts and names are read as question marks") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.h5");
    {
        Hdf5Writer out(file, "cases", provenance);
        out.write_texts("/texts", {"two\nlines", "a\ttab", "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\x8d", "la\xff\xfe", "cut \xe2\x82", "long \xc0\xaf\xe0\x80\xaf\xed\xa0\x80\xf4\x90\x80\x80"}, "");
        out.attribute("/", "law", std::string("iso\ntropic"));
        out.commit();
    }
    const Hdf5Reader in(file, "cases");
    CHECK(in.texts("/texts") == std::vector<std::string>{"two?lines", "a?tab", "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\x8d", "la??", "cut ??", "long ????????????"});
    CHECK(in.text_attribute("/", "law") == "iso?tropic");
    CHECK_THAT(refusal<FileError>([&] { in.array("/no\nwhere"); }), Contains("/no?where: is missing"));
}

TEST_CASE("variable-length texts have no checksum and are refused with advice") {
    const TemporaryFolder folder;
    const std::string file = example_file(folder);
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    const hsize_t two = 2;
    const char* texts[2] = {"left", "a longer one"};
    const hid_t space = H5Screate_simple(1, &two, nullptr), single = H5Screate(H5S_SCALAR);
    const hid_t dataset = H5Dcreate2(id, "/old", type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts);
    const hid_t attribute = H5Acreate2(dataset, "units", type, single, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, &texts[1]);
    for (const hid_t space_of : {space, single}) H5Sclose(space_of);
    H5Aclose(attribute);
    H5Dclose(dataset);
    H5Tclose(type);
    H5Fclose(id);
    const Hdf5Reader in(file, "");
    CHECK_THAT(refusal<FileError>([&] { in.texts("/old"); }), Contains("/old: has texts of variable length") && Contains("make the file again"));
    CHECK_THAT(refusal<FileError>([&] { in.text_attribute("/old", "units"); }), Contains("/old: attribute 'units' has texts of variable length"));
    CHECK(in.texts("/group/words").size() == 3);
}

TEST_CASE("a file of another kind or of a later or outdated format version is refused") {
    const TemporaryFolder folder;
    const std::string file = example_file(folder);
    CHECK_THAT(refusal<FileError>([&] { Hdf5Reader(file, "model"); }), Contains("a.h5") && Contains("'cases'") && Contains("'model'"));
    CHECK_NOTHROW(Hdf5Reader(file, ""));
    set_format_version(file, last_format_version + 1);
    CHECK_THAT(refusal<FileError>([&] { Hdf5Reader(file, "cases"); }), Contains("a.h5") && Contains("later"));
    CHECK_THROWS_AS(Hdf5Reader(file, ""), FileError);
    for (const int of_other_contacts : {solid_format_version - 1, embedded_format_version - 1}) {
        set_format_version(file, of_other_contacts);
        CHECK_THAT(refusal<FileError>([&] { Hdf5Reader(file, "cases"); }), Contains("a.h5") && Contains("make the file again"));
    }
}

TEST_CASE("a dataset that is missing, of another shape or of another type is refused with file and dataset") {
    const TemporaryFolder folder;
    const Hdf5Reader in(example_file(folder), "cases");
    const auto said = [](auto&& read) {
        const std::string text = refusal<FileError>(read);
        CHECK_THAT(text, Contains("a.h5: /group/"));
        return text;
    };
    CHECK_THAT(said([&] { in.array("/group/none"); }), Contains("missing"));
    CHECK_THAT(said([&] { in.vector("/group/counts"); }), Contains("one dimension"));
    CHECK_THAT(said([&] { in.field("/group/numbers"); }), Contains("two dimensions"));
    CHECK_THAT(said([&] { in.array("/group/words"); }), Contains("numbers"));
    CHECK_THAT(said([&] { in.texts("/group/numbers"); }), Contains("texts"));
    said([&] { in.texts("/group/none"); });
    CHECK_THAT(refusal<FileError>([&] { in.children("/none"); }), Contains("/none"));
    CHECK_THAT(said([&] { in.text_attribute("/group/words", "none"); }), Contains("none"));
    CHECK_THROWS_AS(in.number_attribute("/", "none"), FileError);
    CHECK_THROWS_AS(in.text_attribute("/none", "units"), FileError);
}

TEST_CASE("an attribute with many values is refused as a number") {
    const TemporaryFolder folder;
    const std::string file = example_file(folder);
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const hsize_t count = 4096;
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t attribute = H5Acreate2(id, "many", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT);
    const std::vector<double> values(count, 1.0);
    H5Awrite(attribute, H5T_NATIVE_DOUBLE, values.data());
    H5Aclose(attribute);
    H5Sclose(space);
    H5Fclose(id);
    const Hdf5Reader in(file, "cases");
    CHECK_THROWS_AS(in.number_attribute("/", "many"), FileError);
}

TEST_CASE("an attribute of another type or of two mebibytes is reported as missing") {
    const TemporaryFolder folder;
    const std::string file = example_file(folder);
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), space = H5Screate(H5S_SCALAR), type = H5Tcopy(H5T_C_S1);
    const std::string text(std::size_t{2} << 20, 'x');
    H5Tset_size(type, text.size());
    const hid_t attribute = H5Acreate2(id, "long", type, space, H5P_DEFAULT, H5P_DEFAULT);
    REQUIRE(H5Awrite(attribute, type, text.data()) >= 0);
    H5Aclose(attribute);
    H5Tclose(type);
    H5Sclose(space);
    H5Fclose(id);
    const Hdf5Reader in(file, "cases");
    CHECK(in.has_attribute("/", "long"));
    CHECK_THAT(refusal<FileError>([&] { in.text_attribute("/", "long"); }), Contains("attribute 'long' is missing"));
    CHECK_THAT(refusal<FileError>([&] { in.text_attribute("/", "seed"); }), Contains("attribute 'seed' is missing"));
    CHECK_THAT(refusal<FileError>([&] { in.number_attribute("/", "kind"); }), Contains("attribute 'kind' is missing"));
}

TEST_CASE("a file in a missing folder is refused when its writer is made") {
    const TemporaryFolder folder;
    CHECK_THAT(refusal<FileError>([&] { Hdf5Writer(folder.file("none/a.h5"), "cases", provenance); }),
               Contains("none/a.h5") && Contains("cannot write"));
}

TEST_CASE("a dataset that cannot be made is refused by name and the file does not appear") {
    const TemporaryFolder folder;
    {
        Hdf5Writer out(folder.file("a.h5"), "cases", provenance);
        out.write("/x", Array{{1}, {1}}, "1", "x");
        CHECK_THAT(refusal<FileError>([&] { out.write("/x", Array{{1}, {1}}, "1", "x"); }), Contains("/x"));
        CHECK_THROWS_AS(out.attribute("/none", "key", "value"), FileError);
        CHECK_THROWS_AS(out.attribute("/none", "key", 1.0), FileError);
    }
    CHECK(folder.names().empty());
}
