#pragma once

#include <memory>

#include "mesh/spring_mesh.h"
#include "springs/contact_kernel.h"
#include "springs/disc_tables.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Contact kernel of an energy model on a mesh: patches in the plane, in space a disc of radius disc_radius_m [m].
std::unique_ptr<ContactKernel> make_contact_kernel(const SpringMesh& mesh, double disc_radius_m, DiscTables tables = {});
/// The same for the disc and tables of `law`, with its contact_log_scale.
std::unique_ptr<ContactKernel> make_contact_kernel(const SpringMesh& mesh, const EnergyModel& energy_model);

}  // namespace tissue
