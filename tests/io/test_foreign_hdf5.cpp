// HDF5 files that no program of this project writes: external links and values, cyclic groups, other packing.
#include <hdf5.h>

#include <catch2/catch.hpp>

#include "../example.h"
#include "../refusal.h"
#include "error.h"
#include "io/hdf5_store.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const Provenance provenance{"tissuectl test", 1, {}};

/// A file with /group/numbers = 1, 2, 3, changed by `change`.
template <class Change>
std::string changed_file(const TemporaryFolder& folder, const std::string& name, Change&& change) {
    const std::string file = folder.file(name);
    Hdf5Writer out(file, "cases", provenance);
    out.write("/group/numbers", Array{{3}, {1, 2, 3}}, "N", "numbers");
    out.commit();
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    REQUIRE(id >= 0);
    change(id);
    REQUIRE(H5Fclose(id) >= 0);
    return file;
}

/// Makes a dataset of `length` zeros with the property list `creation`, and closes the list.
void make_zeros(hid_t file, const char* name, hsize_t length, hid_t creation) {
    const hsize_t endless = H5S_UNLIMITED;
    const hid_t space = H5Screate_simple(1, &length, H5Pget_layout(creation) == H5D_CHUNKED ? &endless : nullptr);
    const hid_t dataset = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    REQUIRE(dataset >= 0);
    const std::vector<double> zeros(length);
    REQUIRE(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, zeros.data()) >= 0);
    H5Dclose(dataset);
    H5Sclose(space);
    H5Pclose(creation);
}

/// Property list of a dataset in chunks of `piece` values, packed by gzip if a level is given.
hid_t in_pieces(hsize_t piece, int gzip = 0) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    REQUIRE(H5Pset_chunk(creation, 1, &piece) >= 0);
    if (gzip == 0) return creation;
    REQUIRE(H5Pset_shuffle(creation) >= 0);
    REQUIRE(H5Pset_deflate(creation, static_cast<unsigned>(gzip)) >= 0);
    return creation;
}

/// Makes a dataset of three numbers, none written, with the property list `creation`, and closes the list.
void make_dataset(hid_t file, const char* name, hid_t creation) {
    const hsize_t three = 3;
    const hid_t space = H5Screate_simple(1, &three, nullptr), dataset = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    REQUIRE(dataset >= 0);
    H5Dclose(dataset);
    H5Sclose(space);
    H5Pclose(creation);
}

}  // namespace

TEST_CASE("external links to another file are reported as missing") {
    const TemporaryFolder folder;
    const std::string other = changed_file(folder, "other.h5", [](hid_t) {});
    const std::string file = changed_file(folder, "a.h5", [&](hid_t id) {
        REQUIRE(H5Lcreate_external(other.c_str(), "/group", id, "/elsewhere", H5P_DEFAULT, H5P_DEFAULT) >= 0);
        REQUIRE(H5Lcreate_external(other.c_str(), "/group/numbers", id, "/numbers", H5P_DEFAULT, H5P_DEFAULT) >= 0);
    });
    const Hdf5Reader in(file, "cases");
    CHECK(in.vector("/group/numbers").size() == 3);
    CHECK_FALSE(in.has("/numbers"));
    CHECK_FALSE(in.has_attribute("/numbers", "units"));
    for (const std::string name : {"/numbers", "/elsewhere/numbers"}) {
        CHECK_THAT(refusal<FileError>([&] { in.array(name); }), Contains(name + ": is missing"));
        CHECK_THAT(refusal<FileError>([&] { in.shape(name); }), Contains(name + ": is missing"));
        CHECK_THAT(refusal<FileError>([&] { in.text_attribute(name, "units"); }), Contains("'units' is missing"));
    }
    CHECK_THAT(refusal<FileError>([&] { in.children("/elsewhere"); }), Contains("/elsewhere: is missing"));
    CHECK_THAT(refusal<FileError>([&] { in.describe(); }), Contains("is missing"));
}

TEST_CASE("datasets with their values in another file are refused") {
    const TemporaryFolder folder;
    const std::string bytes = folder.file("secret", std::string(24, 'x')), other = changed_file(folder, "other.h5", [](hid_t) {});
    const std::string file = changed_file(folder, "a.h5", [&](hid_t id) {
        const hid_t raw = H5Pcreate(H5P_DATASET_CREATE);
        REQUIRE(H5Pset_external(raw, bytes.c_str(), 0, 24) >= 0);
        make_dataset(id, "/raw", raw);
        const hid_t mapped = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t three = 3;
        const hid_t space = H5Screate_simple(1, &three, nullptr);
        REQUIRE(H5Pset_virtual(mapped, space, other.c_str(), "/group/numbers", space) >= 0);
        H5Sclose(space);
        make_dataset(id, "/mapped", mapped);
    });
    const Hdf5Reader in(file, "cases");
    for (const std::string name : {"/raw", "/mapped"})
        CHECK_THAT(refusal<FileError>([&] { in.array(name); }), Contains(name + ": has its values in another file"));
}

TEST_CASE("a group that contains itself is refused when the datasets are listed") {
    const TemporaryFolder folder;
    const std::string file = changed_file(folder, "a.h5", [](hid_t id) {
        for (const char* name : {"/group/again", "/group/and_again"}) REQUIRE(H5Lcreate_hard(id, "/", id, name, H5P_DEFAULT, H5P_DEFAULT) >= 0);
    });
    const Hdf5Reader in(file, "cases");
    CHECK(in.vector("/group/again/group/numbers")[2] == 3);
    CHECK_THAT(refusal<FileError>([&] { in.datasets(); }), Contains("is a group that also has another name"));
}

TEST_CASE("describe replaces control characters in names") {
    const TemporaryFolder folder;
    const std::string file = changed_file(folder, "a.h5", [](hid_t id) {
        REQUIRE(H5Gcreate2(id, "/gr\x1b[2Joup", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT) >= 0);
        REQUIRE(H5Lmove(id, "/group/numbers", id, "/gr\x1b[2Joup/num\xc2\x9b" "bers", H5P_DEFAULT, H5P_DEFAULT) >= 0);
    });
    const std::vector<std::string> lines = Hdf5Reader(file, "cases").describe();
    REQUIRE(lines.size() == 1);
    CHECK_THAT(lines.front(), Catch::StartsWith("/gr?[2Joup/num??bers "));
}

TEST_CASE("datasets packed by gzip are read up to 256 MiB per file in memory", "[long]") {
    const TemporaryFolder folder;
    constexpr hsize_t mebibyte = 1 << 17;  // in numbers of 8 bytes
    const std::string file = changed_file(folder, "a.h5", [](hid_t id) {
        make_zeros(id, "/small", 1000, in_pieces(100, 9));
        for (const char* name : {"/half", "/other_half"}) make_zeros(id, name, 100 * mebibyte, in_pieces(mebibyte, 1));
        make_zeros(id, "/third", 100 * mebibyte, in_pieces(mebibyte, 1));
        make_zeros(id, "/one", 3, in_pieces(257 * mebibyte, 1));  // three numbers in a chunk that is unpacked whole
    });
    const Hdf5Reader in(file, "cases");
    CHECK(in.vector("/small").size() == 1000);
    for (int twice = 0; twice < 2; ++twice)  // a dataset that is read twice counts once
        CHECK(in.shape("/half") == std::vector<std::size_t>{in.array("/half").values.size()});
    CHECK(in.array("/other_half").values.size() == 100 * mebibyte);
    CHECK_THAT(refusal<FileError>([&] { in.array("/third"); }), Contains("/third: is compressed, and the file's datasets exceed 256 MiB"));
    CHECK_THAT(refusal<FileError>([&] { Hdf5Reader(file, "cases").array("/one"); }), Contains("/one: is compressed, and the file's datasets exceed 256 MiB"));
    CHECK(in.vector("/group/numbers")[2] == 3);
}

TEST_CASE("datasets packed by another filter than gzip or with missing chunks are refused") {
    const TemporaryFolder folder;
    const std::string file = changed_file(folder, "a.h5", [](hid_t id) {
        const hid_t bits = in_pieces(100);
        REQUIRE(H5Pset_nbit(bits) >= 0);
        make_zeros(id, "/bits", 1000, bits);
        make_zeros(id, "/pieces", 1000, in_pieces(300));
        make_zeros(id, "/row", 1000, H5Pcreate(H5P_DATASET_CREATE));
        make_dataset(id, "/absent", in_pieces(3));
    });
    const Hdf5Reader in(file, "cases");
    CHECK_THAT(refusal<FileError>([&] { in.array("/bits"); }), Contains("/bits: is compressed by a filter other than gzip"));
    CHECK_THAT(refusal<FileError>([&] { in.array("/absent"); }), Contains("/absent: declares more values than the file can contain"));
    for (const std::string name : {"/pieces", "/row"}) CHECK(in.vector(name).size() == 1000);
}

TEST_CASE("the claimed size of a dataset is compared with its own storage and not with the file size") {
    const TemporaryFolder folder;
    const std::string file = changed_file(folder, "a.h5", [](hid_t id) {
        make_zeros(id, "/filler", 100000, H5Pcreate(H5P_DATASET_CREATE));
        const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t piece = 1000, many = 1000000;
        REQUIRE(H5Pset_chunk(creation, 1, &piece) >= 0);
        const hid_t space = H5Screate_simple(1, &many, nullptr), dataset = H5Dcreate2(id, "/claims", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
        const hsize_t start = 0;
        const hid_t memory = H5Screate_simple(1, &piece, nullptr);
        REQUIRE(H5Sselect_hyperslab(space, H5S_SELECT_SET, &start, nullptr, &piece, nullptr) >= 0);
        const std::vector<double> values(piece, 1);
        // one chunk of a thousand
        REQUIRE(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()) >= 0);
        for (const hid_t one : {space, memory}) H5Sclose(one);
        H5Dclose(dataset);
        H5Pclose(creation);
    });
    const Hdf5Reader in(file, "cases");
    CHECK(in.vector("/filler").size() == 100000);
    CHECK_THAT(refusal<FileError>([&] { in.array("/claims"); }), Contains("/claims: declares more values than the file can contain"));
}

TEST_CASE("groups more than 32 deep and names of more than 1024 bytes are refused") {
    const TemporaryFolder folder;
    const auto deep = [&](int groups) {
        return changed_file(folder, "deep.h5", [&](hid_t id) {
            std::string name;
            for (int i = 0; i < groups; ++i) {
                name += "/g";
                H5Gclose(H5Gcreate2(id, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
            }
        });
    };
    CHECK(Hdf5Reader(deep(32), "cases").datasets().size() == 1);
    CHECK_THAT(refusal<FileError>([&] { Hdf5Reader(deep(33), "cases").datasets(); }), Contains("is nested in more than 32 groups"));
    const auto named = [&](std::size_t bytes) {
        return changed_file(folder, "long.h5", [&](hid_t id) { H5Gclose(H5Gcreate2(id, std::string(bytes, 'n').c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)); });
    };
    CHECK(Hdf5Reader(named(1024), "cases").children("/").size() == 2);
    CHECK_THAT(refusal<FileError>([&] { Hdf5Reader(named(1025), "cases").children("/"); }), Contains("or one of more than 1024 bytes"));
}
