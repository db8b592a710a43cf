// The block of `paper` with three layers and an inclusion ("lump") in the upper one, whose centre is 27 mm below the
// surface.
//
//        +---------------------+  0.1     Each is a region of its own: studies may give it a material of its own.
//        |  (lump)        top  |          Otherwise it is the same tissue. Only the bottom edge is fixed.
//        +---------------------+  0.05
//        |       middle        |
//        +---------------------+  0.025
//        |       tissue        |
//        +---------------------+  0
//               bottom
//
// Lengths are in metres. Element sizes come from the study (lattice.size_m).
// Sample run: gmsh -2 -clmin 0.01 -clmax 0.01 fem/patient.geo -o patient.msh

Point(1) = {0, 0, 0};     Point(2) = {0.1, 0, 0};
Point(3) = {0.1, 0.025, 0}; Point(4) = {0.1, 0.05, 0};  Point(5) = {0.1, 0.1, 0};
Point(6) = {0, 0.1, 0};     Point(7) = {0, 0.05, 0};    Point(8) = {0, 0.025, 0};

Line(1) = {1, 2};  Line(2) = {2, 3};  Line(3) = {3, 4};  Line(4) = {4, 5};
Line(5) = {5, 6};  Line(6) = {6, 7};  Line(7) = {7, 8};  Line(8) = {8, 1};
Line(9) = {3, 8};  Line(10) = {4, 7};

Point(20) = {0.042, 0.073, 0};
Point(21) = {0.063, 0.073, 0};  Point(22) = {0.042, 0.094, 0};  Point(23) = {0.021, 0.073, 0};  Point(24) = {0.042, 0.052, 0};
Circle(21) = {21, 20, 22};  Circle(22) = {22, 20, 23};  Circle(23) = {23, 20, 24};  Circle(24) = {24, 20, 21};

Curve Loop(1) = {1, 2, 9, 8};
Curve Loop(2) = {3, 10, 7, -9};
Curve Loop(3) = {4, 5, 6, -10};
Curve Loop(4) = {21, 22, 23, 24};
Plane Surface(1) = {1};  Plane Surface(2) = {2};  Plane Surface(3) = {3, 4};  Plane Surface(4) = {4};

Physical Curve("bottom") = {1};
Physical Surface("tissue") = {1};
Physical Surface("middle") = {2};
Physical Surface("top") = {3};
Physical Surface("lump") = {4};
