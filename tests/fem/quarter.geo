// A quarter of a block, for indentation at the centre of its top: x = 0 and y = 0 are planes of symmetry, where
// solid_hertz.edp fixes the normal displacement. Elements are shortest within `zone` of the contact, (0, 0, height).
// Labels: bottom 1, all else 2. Sample run: gmsh -3 -format msh22 tests/fem/quarter.geo -o quarter.msh
DefineConstant[ half = 0.05, height = 0.05, zone = 0.0004, size_near = 0.00009, size_far = 0.02 ];
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, half, half, height};
e = 1e-4 * height;
bottom[] = Surface In BoundingBox{-e, -e, -e, half + e, half + e, e};
free[] = Abs(CombinedBoundary{ Volume{1}; });
free[] -= bottom[];
Physical Surface("bottom", 1) = {bottom[]};
Physical Surface("free", 2) = {free[]};
Physical Volume("tissue", 10) = {1};
Field[1] = Ball;
Field[1].XCenter = 0;  Field[1].YCenter = 0;  Field[1].ZCenter = height;
Field[1].Radius = zone;
Field[1].VIn = size_near;  Field[1].VOut = size_far;
Field[1].Thickness = 3.5 * (size_far - size_near);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.Algorithm = 6;
Mesh.Algorithm3D = 1;
Mesh.Optimize = 1;
General.NumThreads = 1;
