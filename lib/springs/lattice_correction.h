#pragma once

#include <functional>

#include "mesh/facet_table.h"
#include "mesh/shape.h"
#include "springs/tissue_model.h"

namespace tissue {

/// The stiffness of a contact on an embedded lattice depends on where the lattice's cubes happen to lie: by 2 % (rms) on an organ in cubes of 8 mm. This table removes most of that.
/// At each place it has the x for which a contact whose stiffnesses are exp(x) times the law's is as stiff at rest as on average over four lattices: the mesh's own, and
/// those that are shifted by half an edge along two axes. A variation with one period an edge along an axis has the mean 0 over these four.
/// Stiffness here is the logarithm of the trace of the contact's stiffness against the tool's displacement (3 x 3), to first order in x. |x| is 0.5 at the most.
///
/// Of each facet of the mesh (SpringMesh::facets), held ones 0, on parts of a third of a cube's edge by the mean of the facets, 6 at the most. A place that has no contact on one of the
/// four has 0, and so have all where the solid has no shifted lattice. No table for a lattice of more than 10,000 nodes: the compliance between its nodes would take gigabytes.
/// law_on: constants and contact of each of these lattices; it is called by two threads at once.
/// A table for each of the radii (K), in order, of the law's contact at that radius (energy_law.h, resized). No tables where there is none.
std::vector<FacetTable> lattice_corrections(const Shape& shape, const SpringMesh& mesh, const std::function<LawModel(const SpringMesh&)>& law_on, const Eigen::VectorXd& radii_m, int threads);

}  // namespace tissue
