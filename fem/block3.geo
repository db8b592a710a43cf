// A block of tissue in three dimensions, fixed at its bottom, with short elements about a disc on its top.
//
//        +----------------+  top, z = height: the disc is a face of its own, so that its rim is a line of nodes
//       /     (disc)     /|
//      +----------------+ |     x: 0 .. width, y: 0 .. length, z: 0 .. height
//      |     (nodule)   | +     Boundaries are named (bottom 1, the free rest 2); the tissue is 10, the nodule 11.
//      |                |/
//      +----------------+  bottom, z = 0, fixed
//
// Parameters, set with gmsh -setnumber [m]:
//   width, length, height       size of the block
//   contact_x, contact_y        the disc's centre;  disc_radius
//   second_x, second_y          the centre of a second disc of that radius; below 0: none
//   size_near                   element size within disc_radius + 2 mm of the contact;  size_far: far away
//   nodule_x, nodule_y, nodule_z, nodule_radius   a spherical inclusion of its own material; radius 0: none
// Sample run: gmsh -3 -format msh22 -setnumber contact_x 0.043 fem/block3.geo -o path.msh

DefineConstant[ width = 0.1, length = 0.1, height = 0.05, contact_x = 0.05, contact_y = 0.05, disc_radius = 0.007,
                size_near = 0.0035, size_far = 0.015,
                second_x = -1, second_y = -1,
                nodule_x = 0.05, nodule_y = 0.05, nodule_z = 0.025, nodule_radius = 0 ];

If (disc_radius <= 0 || size_near <= 0 || size_far < size_near)
  Error("block3.geo: disc_radius and size_near must be positive and size_far at least size_near, got %g, %g, %g m",
        disc_radius, size_near, size_far);
  Abort;
EndIf
// [m] least distance between the disc's rim and an edge of the top, and between nodule and walls; avoids slivers
least = 0.5 * size_near;
room = contact_x;
room = (contact_y < room) ? contact_y : room;
room = (width - contact_x < room) ? width - contact_x : room;
room = (length - contact_y < room) ? length - contact_y : room;
If (room < disc_radius + least)
  Error("block3.geo: the disc of radius %g m about (%g, %g) m does not fit on the top face", disc_radius, contact_x, contact_y);
  Abort;
EndIf
between = 0;  // [m] from rim to rim
If (second_x >= 0 || second_y >= 0)
  room = second_x;
  room = (second_y < room) ? second_y : room;
  room = (width - second_x < room) ? width - second_x : room;
  room = (length - second_y < room) ? length - second_y : room;
  between = Hypot(second_x - contact_x, second_y - contact_y) - 2 * disc_radius;
  If (room < disc_radius + least)
    Error("block3.geo: the second disc of radius %g m about (%g, %g) m does not fit on the top face", disc_radius, second_x, second_y);
    Abort;
  EndIf
  If (between < 0.0999 * disc_radius)
    Error("block3.geo: two discs of radius %g m are %g m apart, and need 2.1 radii", disc_radius, between + 2 * disc_radius);
    Abort;
  EndIf
EndIf

SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, width, length, height};
Disk(100) = {contact_x, contact_y, height, disc_radius};
nodules[] = {};
If (nodule_radius > 0)
  room = nodule_x;
  room = (nodule_y < room) ? nodule_y : room;
  room = (nodule_z < room) ? nodule_z : room;
  room = (width - nodule_x < room) ? width - nodule_x : room;
  room = (length - nodule_y < room) ? length - nodule_y : room;
  room = (height - nodule_z < room) ? height - nodule_z : room;
  If (room < nodule_radius + least)
    Error("block3.geo: the nodule of radius %g m about (%g, %g, %g) m does not fit inside the block",
          nodule_radius, nodule_x, nodule_y, nodule_z);
    Abort;
  EndIf
  Sphere(2) = {nodule_x, nodule_y, nodule_z, nodule_radius};
  nodules[] = {2};
EndIf
discs[] = {100};
If (between > 0)
  Disk(1000) = {second_x, second_y, height, disc_radius};
  discs[] += {1000};  // 1000, since a nodule has surface 101
EndIf
BooleanFragments{ Volume{1}; Delete; }{ Volume{nodules[]}; Surface{discs[]}; Delete; }

e = 1e-4 * height;  // larger than the tolerance of OpenCASCADE's bounding boxes
bottom[] = Surface In BoundingBox{-e, -e, -e, width + e, length + e, e};
all[] = Abs(CombinedBoundary{ Volume{:}; });
free[] = all[];
free[] -= bottom[];
ball[] = {};
If (nodule_radius > 0)
  r = nodule_radius * 1.001;
  ball[] = Volume In BoundingBox{nodule_x - r, nodule_y - r, nodule_z - r, nodule_x + r, nodule_y + r, nodule_z + r};
EndIf
tissue[] = Volume{:};
tissue[] -= ball[];

Physical Surface("bottom", 1) = {bottom[]};
Physical Surface("free", 2) = {free[]};
Physical Volume("tissue", 10) = {tissue[]};
If (nodule_radius > 0)
  Physical Volume("nodule", 11) = {ball[]};
EndIf

Field[1] = Ball;
Field[1].XCenter = contact_x;  Field[1].YCenter = contact_y;  Field[1].ZCenter = height;
Field[1].Radius = disc_radius + 0.002;
Field[1].VIn = size_near;  Field[1].VOut = size_far;
Field[1].Thickness = 3.5 * (size_far - size_near);
Field[2] = Ball;
Field[2].XCenter = nodule_x;  Field[2].YCenter = nodule_y;  Field[2].ZCenter = nodule_z;
Field[2].Radius = nodule_radius;
Field[2].VIn = (nodule_radius > 0 && 0.6 * nodule_radius < size_far) ? 0.6 * nodule_radius : size_far;
Field[2].VOut = size_far;
Field[2].Thickness = 2.5 * size_far;
Field[3] = Min;
Field[3].FieldsList = {1, 2};
If (between > 0)
  Field[4] = Ball;
  Field[4].XCenter = second_x;  Field[4].YCenter = second_y;  Field[4].ZCenter = height;
  Field[4].Radius = disc_radius + 0.002;
  Field[4].VIn = size_near;  Field[4].VOut = size_far;
  Field[4].Thickness = 3.5 * (size_far - size_near);
  Field[3].FieldsList = {1, 2, 4};
EndIf
If (between > 0 && between < size_near)  // the gap between the rims is shorter than an element
  Field[5] = Ball;
  Field[5].XCenter = (contact_x + second_x) / 2;  Field[5].YCenter = (contact_y + second_y) / 2;  Field[5].ZCenter = height;
  Field[5].Radius = between;
  Field[5].VIn = between;  Field[5].VOut = size_far;
  Field[5].Thickness = 3.5 * size_far;
  Field[3].FieldsList = {1, 2, 4, 5};
EndIf
Background Field = 3;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.Algorithm = 6;     // frontal
Mesh.Algorithm3D = 1;   // Delaunay
Mesh.Optimize = 1;
General.NumThreads = 1;
