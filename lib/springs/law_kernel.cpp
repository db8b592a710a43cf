#include "springs/law_kernel.h"

#include "springs/contact_patch.h"
#include "springs/disc_contact.h"

namespace tissue {

std::unique_ptr<ContactKernel> make_contact_kernel(const SpringMesh& mesh, double disc_radius_m, DiscTables tables) {
    if (mesh.is_solid()) return std::make_unique<DiscContact>(mesh, disc_radius_m, std::move(tables));
    return std::make_unique<ContactSurface>(mesh);
}

std::unique_ptr<ContactKernel> make_contact_kernel(const SpringMesh& mesh, const EnergyModel& law) {
    std::unique_ptr<ContactKernel> kernel = make_contact_kernel(mesh, law.disc_radius_m, law.disc);
    kernel->scale(law.contact_log_scale);
    return kernel;
}

}  // namespace tissue
