// Studies: TOML, every rule of lib/study, and the plan that make asks of one.
#include "cases/plan.h"
#include "cases/study_mesh.h"
#include "fuzz_file.h"
#include "study/study.h"

using namespace tissue;

FUZZ_TARGET(study)(const std::uint8_t* data, std::size_t size) {
    const FuzzFile file(data, size, "study.toml");
    reads([&] {
        const Study study = read_study(file);
        make_plan(study);
        long nodes = 1;
        for (const int cells : study.cells) nodes *= cells + 1;
        if (study.geometry.is_block() && nodes < 2000) study_mesh(study, {}, study.springs.topology);
    });
    return 0;
}
