// An organ of a liver's size and look, in space: 120 mm by 90 mm by 55 mm, a thick right lobe and a thin left one that grow
// into each other, smooth all round above a flat bed on which it rests and where it is held.
//
//               __------__                       Seen from the front; x to the right, z up, y away.
//            .-'          ''-.__
//          .'    right           ''--..__        The surface is free but for its underside ("bed").
//         (      lobe                left ''.    The lobes are ellipsoids; a third fills the valley between them.
//          '.______________________________.'
//                        bed
//
// In millimetres: studies say geometry.unit_m = 0.001. Sizes of elements come from the study (lattice.size_m).
// Sample run: gmsh -3 -clmin 12 -clmax 12 fem/organ3.geo -o organ3.msh

SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 1};  Dilate{ {0, 0, 0}, {40, 45, 43} }{ Volume{1}; }  Translate{40, 45, 12}{ Volume{1}; }
Sphere(2) = {0, 0, 0, 1};  Dilate{ {0, 0, 0}, {52, 34, 24} }{ Volume{2}; }  Translate{68, 38, 8}{ Volume{2}; }
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Box(4) = {-50, -50, 0, 250, 250, 100};
BooleanIntersection(5) = { Volume{3}; Delete; }{ Volume{4}; Delete; };
e = 0.01;
bed[] = Surface In BoundingBox{-50, -50, -e, 200, 200, e};
Physical Surface("bed") = {bed[]};
Physical Volume("tissue") = {5};
