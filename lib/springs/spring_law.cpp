#include "springs/spring_law.h"

namespace tissue {

std::unique_ptr<SpringLaw> make_isotropic_law(), make_axial_law(), make_geometric_law(), make_rubber_law();

const Registry<MakeSpringLaw>& spring_laws() {
    static const Registry<MakeSpringLaw> laws = [] {
        std::vector<std::pair<std::string, MakeSpringLaw>> kinds;
        for (const MakeSpringLaw make : {make_isotropic_law, make_axial_law, make_geometric_law, make_rubber_law})
            kinds.emplace_back(make()->name(), make);
        return Registry<MakeSpringLaw>("spring law", std::move(kinds));
    }();
    return laws;
}

std::unique_ptr<SpringLaw> make_spring_law(const std::string& name) { return spring_laws().at(name)(); }

}  // namespace tissue
