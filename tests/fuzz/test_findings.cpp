// Runs the fuzz targets on inputs of earlier findings (tests/data/fuzz/READER/) and on the seeds of fuzzing.
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#define TARGET(reader) extern "C" int fuzz_##reader(const std::uint8_t* data, std::size_t size);
#define TARGETS(use) \
    use(study) use(measured) use(histories) use(fe) use(msh) use(pokes) use(replay) use(datagram) use(message) use(request) use(model) use(cases) use(store) use(surface)
TARGETS(TARGET)

namespace {

struct Target {
    std::string name;
    int (*read)(const std::uint8_t*, std::size_t);
};

#define ENTRY(reader) {#reader, fuzz_##reader},
const std::vector<Target> targets = {TARGETS(ENTRY)};

int read_all(const Target& target, const std::string& folder) {
    int files = 0;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder + "/" + target.name, none)) {
        INFO(entry.path().string());
        std::ifstream in(entry.path(), std::ios::binary);
        const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
        CHECK_NOTHROW(target.read(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
        ++files;
    }
    return files;
}

}  // namespace

TEST_CASE("readers read or refuse the inputs of earlier fuzz findings", "[fuzz]") {
    int files = 0;
    for (const Target& target : targets) files += read_all(target, "tests/data/fuzz");
    CHECK(files > 0);
}

TEST_CASE("every listed fuzz target reads or refuses its seeds and an empty input", "[fuzz]") {
    for (const Target& target : targets) {
        read_all(target, "tests/fuzz/corpus");
        CHECK_NOTHROW(target.read(nullptr, 0));
    }
    for (const auto& entry : std::filesystem::directory_iterator("tests/fuzz")) {  // TARGETS must list every target
        const std::string name = entry.path().stem().string();
        if (name.rfind("fuzz_", 0) != 0 || name == "fuzz_server" || entry.path().extension() != ".cpp") continue;
        INFO(name);
        bool listed = false;
        for (const Target& target : targets) listed = listed || "fuzz_" + target.name == name;
        CHECK(listed);
    }
}
