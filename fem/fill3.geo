// Fills a closed surface with tetrahedra, for a disc that indents it. `tissuectl rim` has refined the surface about the
// disc already, and elements are short there too. The surface's triangles are kept: fixed 1, free 2, under the disc 3.
// The tissue is 10. A nodule inside it is 11, and elements follow its surface: a sphere, or with nodule_shape 1 the
// triangles of gmsh's surface 4.
//
// Parameters, set with gmsh -setnumber [m]: contact_x, contact_y, contact_z, disc_radius, size_near, size_far,
// nodule_x, nodule_y, nodule_z, nodule_radius (0: none), as in block3.geo. `better` [1]: gmsh optimises tetrahedra of
// lower quality.
// Sample run (one line): gmsh -3 -format msh22 -setnumber contact_x 0.04 -setnumber contact_y 0.045
//   -setnumber contact_z 0.055 surface.msh fem/fill3.geo -o path.msh

DefineConstant[ contact_x = 0, contact_y = 0, contact_z = 0, disc_radius = 0.007, size_near = 0.0035, size_far = 0.015,
                nodule_x = 0, nodule_y = 0, nodule_z = 0, nodule_radius = 0, nodule_shape = 0, better = 0.6 ];

all[] = Surface{:};
If (nodule_shape)
  all[] -= {4};
EndIf
Surface Loop(1) = {all[]};
If (nodule_shape)
  Surface Loop(2) = {4};
  Volume(1) = {1, 2};
  Volume(2) = {2};
  Physical Volume("nodule", 11) = {2};
ElseIf (nodule_radius > 0)
  // The nodes of the sphere lie at 1.03 radii. Its facets, of 0.6 radii, then enclose the ball's volume within 3 %.
  // With nodes at one radius the volume is 8 % too small. An indentation 5 mm above a nodule of 8 mm that is four times
  // as stiff is then 2 % softer.
  r = 1.03 * nodule_radius;
  // A sphere of eight faces between the ends of its axes, in gmsh's built-in geometry kernel. OpenCASCADE's kernel
  // cannot be combined with a surface of triangles.
  middle = newp;  Point(middle) = {nodule_x, nodule_y, nodule_z};
  ends[] = {};  // -x, x, -y, y, -z, z
  For d In {0:2}
    For s In {-1:1:2}
      p = newp;
      Point(p) = {nodule_x + (d == 0) * s * r, nodule_y + (d == 1) * s * r, nodule_z + (d == 2) * s * r};
      ends[] += {p};
    EndFor
  EndFor
  arcs[] = {};  // [4 d + 2 s + t]: from end s of axis d to end t of the next one
  For d In {0:2}
    For s In {0:1}
      For t In {0:1}
        l = newl;
        Circle(l) = {ends[2 * d + s], middle, ends[2 * ((d + 1) % 3) + t]};
        arcs[] += {l};
      EndFor
    EndFor
  EndFor
  faces[] = {};
  For s In {0:1}
    For t In {0:1}
      For q In {0:1}
        l = newll;  Curve Loop(l) = {arcs[2 * s + t], arcs[4 + 2 * t + q], arcs[8 + 2 * q + s]};
        f = news;   Surface(f) = {l};
        faces[] += {f};
      EndFor
    EndFor
  EndFor
  Surface Loop(2) = {faces[]};
  Volume(1) = {1, 2};
  Volume(2) = {2};
  Physical Volume("nodule", 11) = {2};
Else
  Volume(1) = {1};
EndIf
Physical Volume("tissue", 10) = {1};

Field[1] = Ball;
Field[1].XCenter = contact_x;  Field[1].YCenter = contact_y;  Field[1].ZCenter = contact_z;
Field[1].Radius = disc_radius + 0.002;
// The Delaunay algorithm makes larger tetrahedra than asked for. With size_near itself, elements under the disc invert
// before 8 mm of displacement.
Field[1].VIn = 0.75 * size_near;  Field[1].VOut = size_far;
Field[1].Thickness = 3.5 * (size_far - size_near);
Field[2] = Ball;
Field[2].XCenter = nodule_x;  Field[2].YCenter = nodule_y;  Field[2].ZCenter = nodule_z;
Field[2].Radius = nodule_radius;
Field[2].VIn = (nodule_radius > 0 && 0.6 * nodule_radius < size_far) ? 0.6 * nodule_radius : size_far;
Field[2].VOut = size_far;
Field[2].Thickness = 2.5 * size_far;
Field[3] = Min;
Field[3].FieldsList = {1, 2};
Background Field = (nodule_radius > 0) ? 3 : 1;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.Algorithm3D = 1;   // Delaunay
Mesh.Optimize = 1;
Mesh.OptimizeThreshold = better;
General.NumThreads = 1;
