// A section through an organ with a liver's size and shape: 104 mm by 60 mm, curved all round, with an inclusion
// ("lump").
//
//            ___----___
//        .-'           ''--..___        The surface is free except for its underside ("bed"), which is fixed.
//       (      (lump)            ''.    "lump" is a region of its own: studies may give it a material of its own.
//        '.                     _.-'    Otherwise it is the same tissue.
//          '-._____________..--'
//                  bed
//
// Lengths are in millimetres: studies set geometry.unit_m = 0.001. Element sizes come from the study (lattice.size_m).
// Sample run: gmsh -2 -clmin 10 -clmax 10 fem/organ.geo -o organ.msh

Point(1) = {12, 12, 0};  Point(2) = {40, 4, 0};   Point(3) = {72, 8, 0};                          // the bed
Point(4) = {93, 21, 0};  Point(5) = {104, 36, 0}; Point(6) = {92, 45, 0};  Point(7) = {67, 51, 0};
Point(8) = {41, 63, 0};  Point(9) = {17, 58, 0};  Point(10) = {2, 36, 0};

Spline(1) = {1, 2, 3};
Spline(2) = {3, 4, 5, 6, 7, 8, 9, 10, 1};

Point(20) = {38, 36, 0};
Point(21) = {48, 36, 0};  Point(22) = {38, 46, 0};  Point(23) = {28, 36, 0};  Point(24) = {38, 26, 0};
Circle(3) = {21, 20, 22};  Circle(4) = {22, 20, 23};  Circle(5) = {23, 20, 24};  Circle(6) = {24, 20, 21};

Curve Loop(1) = {1, 2};
Curve Loop(2) = {3, 4, 5, 6};
Plane Surface(1) = {1, 2};
Plane Surface(2) = {2};

Physical Curve("bed") = {1};
Physical Surface("tissue") = {1};
Physical Surface("lump") = {2};
