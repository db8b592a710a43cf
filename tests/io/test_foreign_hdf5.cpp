// HDF5 files as no program of ours writes them: names and values that lead elsewhere, groups within themselves.
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

/// A dataset of three numbers, made as `creation` says, which it closes.
void make_dataset(hid_t file, const char* name, hid_t creation) {
    const hsize_t three = 3;
    const hid_t space = H5Screate_simple(1, &three, nullptr), dataset = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    REQUIRE(dataset >= 0);
    H5Dclose(dataset);
    H5Sclose(space);
    H5Pclose(creation);
}

}  // namespace

TEST_CASE("names that lead to another file lead nowhere") {
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

TEST_CASE("values that lie in another file are refused") {
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

TEST_CASE("a group within itself is refused, and not walked for ever") {
    const TemporaryFolder folder;
    const std::string file = changed_file(folder, "a.h5", [](hid_t id) {
        for (const char* name : {"/group/again", "/group/and_again"}) REQUIRE(H5Lcreate_hard(id, "/", id, name, H5P_DEFAULT, H5P_DEFAULT) >= 0);
    });
    const Hdf5Reader in(file, "cases");
    CHECK(in.vector("/group/again/group/numbers")[2] == 3);
    CHECK_THAT(refusal<FileError>([&] { in.datasets(); }), Contains("is a group of another name, too"));
}

TEST_CASE("what a file is described by obeys no terminal") {
    const TemporaryFolder folder;
    const std::string file = changed_file(folder, "a.h5", [](hid_t id) {
        REQUIRE(H5Gcreate2(id, "/gr\x1b[2Joup", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT) >= 0);
        REQUIRE(H5Lmove(id, "/group/numbers", id, "/gr\x1b[2Joup/num\xc2\x9b" "bers", H5P_DEFAULT, H5P_DEFAULT) >= 0);
    });
    const std::vector<std::string> lines = Hdf5Reader(file, "cases").describe();
    REQUIRE(lines.size() == 1);
    CHECK_THAT(lines.front(), Catch::StartsWith("/gr?[2Joup/num??bers "));
}
