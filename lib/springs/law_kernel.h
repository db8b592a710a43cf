#pragma once

#include <memory>

#include "mesh/spring_mesh.h"
#include "springs/contact_kernel.h"
#include "springs/disc_tables.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Contacts of a law on a mesh: the patch in the plane; in space a disc of that radius [m].
std::unique_ptr<ContactKernel> make_contact_kernel(const SpringMesh& mesh, double disc_radius_m, DiscTables tables = {});
/// Those of a model's law, with its contact_log_scale.
std::unique_ptr<ContactKernel> make_contact_kernel(const SpringMesh& mesh, const LawModel& law);

}  // namespace tissue
