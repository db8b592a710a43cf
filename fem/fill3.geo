// Fills a closed surface with tetrahedra for a disc that presses on it: finely about the disc, as `tissuectl rim` has divided
// the surface already. The surface's triangles stay as they are: held 1, free 2, under the disc 3.
//
// Parameters, set with gmsh -setnumber [m]: contact_x, contact_y, contact_z, disc_radius, size_near, size_far, as block3.geo
// Sample run (one line): gmsh -3 -format msh22 -setnumber contact_x 0.04 -setnumber contact_y 0.045
//   -setnumber contact_z 0.055 surface.msh fem/fill3.geo -o path.msh

DefineConstant[ contact_x = 0, contact_y = 0, contact_z = 0, disc_radius = 0.007, size_near = 0.0035, size_far = 0.015 ];

all[] = Surface{:};
Surface Loop(1) = {all[]};
Volume(1) = {1};
Physical Volume("tissue", 10) = {1};

Field[1] = Ball;
Field[1].XCenter = contact_x;  Field[1].YCenter = contact_y;  Field[1].ZCenter = contact_z;
Field[1].Radius = disc_radius + 0.002;
// Delaunay's tetrahedra are larger than asked for; on ones of size_near, elements under the disc fold on the way to 8 mm
Field[1].VIn = 0.75 * size_near;  Field[1].VOut = size_far;
Field[1].Thickness = 3.5 * (size_far - size_near);
Background Field = 1;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.Algorithm3D = 1;   // Delaunay
Mesh.Optimize = 1;
Mesh.OptimizeThreshold = 0.6;
General.NumThreads = 1;
