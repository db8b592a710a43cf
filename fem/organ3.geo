// An organ in space with a liver's size and shape: 120 mm by 90 mm by 55 mm, a thick right lobe and a thin left one. It
// is smooth above a flat bed, where it is fixed.
//
//           __----__
//        .-'        '-._                          Seen from the front: x to the right, z up, y away. The lobes are
//       /     right     ''--...___                ellipsoids; the valley between them is rounded off.
//      (      lobe          left  ''-.            The surface is free except for its underside ("bed").
//       \                   lobe      )
//        '---------------------------'
//                     bed
//
// Lengths are in millimetres: studies set geometry.unit_m = 0.001. Element sizes come from the study (lattice.size_m).
// Sample run: gmsh -3 -clmin 12 -clmax 12 fem/organ3.geo -o organ3.msh

SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 1};
Dilate{ {0, 0, 0}, {40, 45, 43} }{ Volume{1}; }  // half axes of the right lobe
Translate{40, 45, 12}{ Volume{1}; }
Sphere(2) = {0, 0, 0, 1};
Dilate{ {0, 0, 0}, {52, 34, 24} }{ Volume{2}; }  // half axes of the left lobe
Translate{68, 38, 8}{ Volume{2}; }
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
valley[] = Fillet{3}{2, 3, 4, 7}{15};            // curves where the lobes meet; radius

Box(40) = {-50, -50, 0, 250, 250, 100};          // the region above the bed
BooleanIntersection(50) = { Volume{valley[0]}; Delete; }{ Volume{40}; Delete; };

e = 0.01;
bed[] = Surface In BoundingBox{-50, -50, -e, 200, 200, e};
Physical Surface("bed") = {bed[]};
Physical Volume("tissue") = {50};
