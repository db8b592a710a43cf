// Studies: TOML, every rule of lib/study, and the plan for make.
#include "cases/plan.h"
#include "fuzz_file.h"
#include "study/study.h"

using namespace tissue;

FUZZ_TARGET(study)(const std::uint8_t* data, std::size_t size) {
    const FuzzFile file(data, size, "study.toml");
    reads([&] {
        make_plan(read_study(file));  // with the springs of a block
    });
    return 0;
}
