#pragma once

#include <functional>

#include "mesh/facet_table.h"
#include "mesh/shape.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Correction of the contact stiffness for the position of an embedded lattice relative to the contact. Without it the
/// stiffness varies by 2 % (rms) on an organ in cubes of 8 mm. The table removes most of that. At each place it gives x
/// such that a contact with exp(x) times the model's stiffnesses is as stiff at rest as the average over four lattices:
/// the mesh's own, and three shifted by half an edge along two axes each. A variation whose period along an axis is one
/// edge has mean 0 over these four. The stiffness compared is the log of the trace of the contact's stiffness against
/// the tool's displacement (3 x 3). x is accurate to first order and limited to |x| <= 0.5.
///
/// Result: one table per radius of radii_m (K), in that order, for the contact resized to that radius (resized() in
/// energy_model.h). Each table covers the facets of the mesh (SpringMesh::facets). Each facet is divided into parts of
/// about a third of a cube's edge, by the mean facet size, at most 6 along an edge. Fixed facets have x = 0, and so do
/// places without a contact on one of the four lattices. All places have 0 if a shifted lattice of the solid does not
/// exist. No tables for a lattice of more than 10,000 nodes, because the compliance between its nodes would take
/// gigabytes.
/// energy_model_on: makes constants and contact on each of these lattices; two threads call it at once.
std::vector<FacetTable> lattice_corrections(const Shape& shape, const SpringMesh& mesh, const std::function<EnergyModel(const SpringMesh&)>& energy_model_on, const Eigen::VectorXd& radii_m, int threads);

}  // namespace tissue
