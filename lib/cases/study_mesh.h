#pragma once

#include <optional>
#include <string>

#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// The solid of a study in space: its shape, or its block.
/// Throws MismatchError when the study has a shape and none is given.
Shape study_solid(const Study& study, const std::optional<Shape>& shape);

/// The study's spring mesh of a topology. In the plane its springs are those of the block's lattice or the edges of a
/// shape's triangles; in space they belong to a lattice in which the solid is embedded.
/// Throws MismatchError when the study has a shape and none is given, when their dimensions differ, or when the
/// topology needs the block's lattice.
SpringMesh study_mesh(const Study& study, const std::optional<Shape>& shape, const std::string& topology);

/// The nodes at which displacements are compared (N x D). Throws as study_mesh.
NodeField study_nodes(const Study& study, const std::optional<Shape>& shape);

/// Reads the shape of a study that has one from the mesh file that tissuectl shape wrote; nothing for the block.
/// Throws MismatchError when the file is needed and its name is empty; FileError where it cannot be read; as
/// refuse_nodule_outside.
std::optional<Shape> study_shape(const Study& study, const std::string& mesh_file);

/// Throws StudyError where the study's nodule is not inside the shape, or nearer than half an element to its surface.
/// The mesh of a path would have slivers there.
void refuse_nodule_outside(const Study& study, const Shape& shape);

}  // namespace tissue
