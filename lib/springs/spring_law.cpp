#include "springs/spring_law.h"

namespace tissue {

std::unique_ptr<SpringLaw> make_isotropic_law(), make_axial_law(), make_geometric_law();

const Registry<MakeSpringLaw>& spring_laws() {
    static const Registry<MakeSpringLaw> laws(
        "spring law", {make_isotropic_law, make_axial_law, make_geometric_law},
        [](MakeSpringLaw make) { return make()->name(); });
    return laws;
}

std::unique_ptr<SpringLaw> make_spring_law(const std::string& name) { return spring_laws().at(name)(); }

}  // namespace tissue
