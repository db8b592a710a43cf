#pragma once

#include <optional>
#include <string>

#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// The solid of a study in space: its shape, or its block.
/// Throws MismatchError when the study has a shape and none is given.
Shape study_solid(const Study& study, const std::optional<Shape>& shape);

/// The study's nodes with the springs of a topology on them: in the plane the block's lattice or the edges of a shape's triangles, in space a lattice that the solid is embedded in.
/// Throws MismatchError when the study has a shape and none is given, or the topology is not the shape's.
SpringMesh study_mesh(const Study& study, const std::optional<Shape>& shape, const std::string& topology);

/// Its nodes alone (N x D). Throws as study_mesh.
NodeField study_nodes(const Study& study, const std::optional<Shape>& shape);

/// The shape of a study that has one, from the mesh file that tissuectl shape wrote; nothing for the block.
/// Throws MismatchError when the file is needed and its name is empty; FileError; as refuse_nodule_outside.
std::optional<Shape> study_shape(const Study& study, const std::string& mesh_file);

/// Throws StudyError where the study's nodule does not lie in the shape, half an element from its surface: there the mesh of a
/// path has slivers.
void refuse_nodule_outside(const Study& study, const Shape& shape);

}  // namespace tissue
