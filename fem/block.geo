// A rectangular block of tissue, split into triangles that are mirror-symmetric about its vertical axis.
//
//   top    +-----+-----+        Each half is a structured grid cut along one diagonal: "\" on the left,
//          |\ \ \|/ / /|        "/" on the right. The two top corners are contacts of studies. Each of
//   left   | \ \ | / / | right  them lies in two triangles, so loads to the left and right give mirrored
//          |\ \ \|/ / /|        results.
//   bottom +-----+-----+        Boundaries are named (bottom 1, right 2, top 3, left 4); the tissue is 10.
//
// Parameters, set with gmsh -setnumber:
//   width, height   [m]  size of the block
//   cells_x, cells_y     elements along each side; cells_x must be even for the mirror symmetry
// Sample run: gmsh -2 -format msh22 -setnumber cells_x 10 -setnumber cells_y 10 fem/block.geo -o block.msh

DefineConstant[ width = 0.1, height = 0.1, cells_x = 10, cells_y = 10 ];

If (cells_x % 2 != 0)
  Error("block.geo: cells_x must be even, so that the two halves mirror each other, got %g", cells_x);
  Abort;
EndIf

Point(1) = {0, 0, 0};            Point(2) = {width / 2, 0, 0};       Point(3) = {width, 0, 0};
Point(4) = {width, height, 0};   Point(5) = {width / 2, height, 0};  Point(6) = {0, height, 0};

Line(1) = {1, 2};  Line(2) = {2, 3};  // bottom
Line(3) = {3, 4};                     // right
Line(4) = {4, 5};  Line(5) = {5, 6};  // top
Line(6) = {6, 1};                     // left
Line(7) = {2, 5};                     // axis of symmetry, inside the tissue

Curve Loop(1) = {1, 7, 5, 6};   Plane Surface(1) = {1};  // left half
Curve Loop(2) = {2, 3, 4, -7};  Plane Surface(2) = {2};  // right half

Transfinite Curve{1, 2, 4, 5} = cells_x / 2 + 1;
Transfinite Curve{3, 6, 7} = cells_y + 1;
Transfinite Surface{1} = {1, 2, 5, 6} Left;
Transfinite Surface{2} = {2, 3, 4, 5} Right;

Physical Curve("bottom", 1) = {1, 2};
Physical Curve("right", 2) = {3};
Physical Curve("top", 3) = {4, 5};
Physical Curve("left", 4) = {6};
Physical Surface("tissue", 10) = {1, 2};
