#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "../../cli/serve/show.h"
#include "../example.h"
#include "../haptic/haptic_example.h"

namespace tissue::serve {

/// The example with FE forces: 2 N per metre of tool displacement, along its direction.
TissueModel with_forces();

struct Shown {
    TissueModel tissue = with_forces();
    HapticModel model{tissue, {}};
    Scene scene{tissue, model};
};

/// Cases of that model: its FE forces, and displacements that differ between load cases and between nodes.
Cases cases_of(const TissueModel& tissue);

bool in_tissue(const Scene& scene, const Point& p, double margin = 0);

/// A show of two models that records the messages to each client.
struct Stand {
    TemporaryFolder folder;
    std::unique_ptr<Stage> stage;
    std::map<int, std::vector<nlohmann::json>> heard;
    std::unique_ptr<Show> show;
    double now_s = 100;
    explicit Stand(const std::optional<Cases>& cases = {}) {
        if (cases) write_cases(folder.file("cases.h5"), *cases, {"test", 1, {}});
        write_model(folder.file("a.h5"), with_forces(), {"test", 1, {}});
        write_model(folder.file("b.h5"), haptic_example({"grid8", "axial"}), {"test", 1, {}});
        stage = std::make_unique<Stage>(std::vector<std::string>{folder.file("a.h5"), folder.file("b.h5")}, StageOptions{{}, false});
        show = std::make_unique<Show>(*stage, [this](int client, const std::string& text) { heard[client].push_back(nlohmann::json::parse(text)); });
    }
    std::string last_holder(int client) const {
        for (auto k = heard.at(client).rbegin(); k != heard.at(client).rend(); ++k)
            if ((*k)["type"] == "control") return (*k)["holder"];
        return "";
    }
    bool point(int client, double x, double y, bool down) {
        return !show->hear(client, nlohmann::json{{"type", "pointer"}, {"x", x}, {"y", y}, {"down", down}}.dump(), now_s);
    }
    /// Advances the clock of the show, and does not wait for ticks.
    void pass(double seconds) {
        for (const double end = now_s + seconds; now_s < end; now_s += 0.016) show->step(now_s);
    }
};

}  // namespace tissue::serve
