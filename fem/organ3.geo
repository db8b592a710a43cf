// An organ in space, of a liver's size and look: 120 mm by 90 mm by 55 mm, a thick right lobe and a thin left one, smooth
// above a flat bed on which it rests and where it is held.
//
//           __----__
//        .-'        '-._                          Seen from the front: x to the right, z up, y away. The lobes are
//       /     right     ''--...___                ellipsoids; where they meet, the valley is rounded off.
//      (      lobe          left  ''-.            The surface is free but for its underside ("bed").
//       \                   lobe      )
//        '---------------------------'
//                     bed
//
// In millimetres: studies say geometry.unit_m = 0.001. Sizes of elements come from the study (lattice.size_m).
// Sample run: gmsh -3 -clmin 12 -clmax 12 fem/organ3.geo -o organ3.msh

SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 1};
Dilate{ {0, 0, 0}, {40, 45, 43} }{ Volume{1}; }  // half axes of the right lobe
Translate{40, 45, 12}{ Volume{1}; }
Sphere(2) = {0, 0, 0, 1};
Dilate{ {0, 0, 0}, {52, 34, 24} }{ Volume{2}; }  // of the left
Translate{68, 38, 8}{ Volume{2}; }
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
valley[] = Fillet{3}{2, 3, 4, 7}{15};            // the curves along which the lobes meet; radius

Box(40) = {-50, -50, 0, 250, 250, 100};          // all that is above the bed
BooleanIntersection(50) = { Volume{valley[0]}; Delete; }{ Volume{40}; Delete; };

e = 0.01;
bed[] = Surface In BoundingBox{-50, -50, -e, 200, 200, e};
Physical Surface("bed") = {bed[]};
Physical Volume("tissue") = {50};
