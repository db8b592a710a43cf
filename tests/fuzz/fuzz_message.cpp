// Messages of pages: one message per line, each passed to the show, 20 ms apart.
#include "../../cli/serve/show.h"
#include "../haptic/haptic_example.h"
#include "fuzz_file.h"

using namespace tissue;
using namespace tissue::serve;

namespace {

std::string model_file(const TissueModel& model) {
    const std::string file = FuzzFile::folder() + "/served.h5";
    write_model(file, model, {"fuzz", 0, {}});
    return file;
}

}  // namespace

FUZZ_TARGET(message)(const std::uint8_t* data, std::size_t size) {
    static Stage stage({model_file(haptic_example({"grid4", "isotropic", 3}))}, StageOptions{{}, false});
    double now_s = 100;
    Show show(stage, [](int, const std::string& text) { must(!text.empty(), "an empty message is sent"); });
    show.join(0);
    show.join(1);
    const std::string all(reinterpret_cast<const char*>(data), size);
    for (std::size_t at = 0, line = 0; at <= all.size() && line < 64; ++line, now_s += 0.02) {
        const std::size_t end = std::min(all.find('\n', at), all.size());
        const std::string text = all.substr(at, end - at);
        at = end + 1;
        const auto parsed = parse_message(text);
        if (const Refusal* refusal = std::get_if<Refusal>(&parsed)) {
            must(!refusal->reason.empty() && refusal->reason.size() < 124, "a reason is empty or too long for a close frame");
            bye_message(refusal->reason);
        }
        if (const auto refusal = show.hear(static_cast<int>(line % 2), text, now_s)) must(refusal->reason.size() < 124, "a reason is too long for a close frame");
        show.step(now_s);
    }
    stage.channel().pause(false);
    return 0;
}
