#include "springs/energy_model_kernel.h"

#include "springs/contact_patch.h"
#include "springs/disc_contact.h"

namespace tissue {

std::unique_ptr<ContactKernel> make_contact_kernel(const SpringMesh& mesh, double disc_radius_m, DiscTables tables) {
    if (mesh.is_solid()) return std::make_unique<DiscContact>(mesh, disc_radius_m, std::move(tables));
    return std::make_unique<ContactSurface>(mesh);
}

std::unique_ptr<ContactKernel> make_contact_kernel(const SpringMesh& mesh, const EnergyModel& energy_model) {
    std::unique_ptr<ContactKernel> kernel = make_contact_kernel(mesh, energy_model.disc_radius_m, energy_model.disc);
    kernel->scale(energy_model.contact_log_scale);
    return kernel;
}

}  // namespace tissue
