// A rectangular block of tissue whose elements shrink towards the free surface and towards the ends of one patch.
//
//   top    +--+---+-----+---+--+       A grid of graded columns and rows. Each cell is cut along one diagonal: "\"
//          +--+---+-----+---+--+       left of the middle, "/" right of it, as in block.geo. Mirrored contacts get
//   left   |  |   |     |   |  | right mirrored meshes.
//          |  |   |     |   |  |       Boundaries are named (bottom 1, right 2, top 3, left 4); the tissue is 10.
//   bottom +--+---+-----+---+--+
//
// Parameters, set with gmsh -setnumber:
//   width, height     [m]  size of the block
//   surface_size      [m]  element size normal to the free surface, at it (0: no grading towards it)
//   growth                 ratio of an element's length to that of its neighbour on the finer side
//   end_size          [m]  element size along the surface at the patch's ends
//   contact_x, contact_y [m]  the patch's centre, on the free surface
//   patch_half_width  [m]  along the surface, also round corners; 0: no patch
// Sample run: gmsh -2 -format msh22 -setnumber contact_x 0 -setnumber contact_y 0.05 -setnumber patch_half_width 0.005
//   -setnumber end_size 0.001 fem/block_graded.geo -o patch.msh

DefineConstant[ width = 0.1, height = 0.1, surface_size = 0.005, growth = 1.4, end_size = 0.0025,
                contact_x = 0, contact_y = 0.05, patch_half_width = 0 ];

If (growth <= 1)
  Error("block_graded.geo: growth must exceed 1, got %g", growth);
  Abort;
EndIf

// ---- breaks of x and y: block sides and patch ends, with the element size wanted there (0: none prescribed)
on_left = Fabs(contact_x) < 1e-9 * width;
on_right = Fabs(contact_x - width) < 1e-9 * width;
on_top = Fabs(contact_y - height) < 1e-9 * height;
x_break[] = {0};  x_size[] = {surface_size};
y_break[] = {0};  y_size[] = {0};
If (patch_half_width > 0)
  If (!on_left && !on_right && !on_top)
    Error("block_graded.geo: the contact (%g, %g) is not on the free surface", contact_x, contact_y);
    Abort;
  EndIf
  // Position t of the patch's two ends along the surface, unrolled at the top's corners. t < 0 is the depth on the left
  // wall below its corner, 0 to width is the top, and larger t is the right wall.
  t = contact_x;
  If (!on_top && on_left)
    t = contact_y - height;
  EndIf
  If (!on_top && on_right)
    t = width + height - contact_y;
  EndIf
  For side In {-1 : 1 : 2}
    e = t + side * patch_half_width;
    If (e > 1e-9 * width && e < width * (1 - 1e-9))
      x_break[] += e;  x_size[] += end_size;
    EndIf
  EndFor
  // Patch ends on a wall, from the lower one upwards.
  low = height;  high = height;
  For side In {-1 : 1 : 2}
    e = t + side * patch_half_width;
    depth = (e < 0) ? -e : e - width;
    If (depth > 1e-9 * height)
      If (height - depth < low)
        high = low;  low = height - depth;
      Else
        high = height - depth;
      EndIf
    EndIf
  EndFor
  If (low < height)
    y_break[] += low;  y_size[] += end_size;
  EndIf
  If (high < height)
    y_break[] += high;  y_size[] += end_size;
  EndIf
EndIf
If (#x_break[] == 1)
  x_break[] += width / 2;  x_size[] += 0;
EndIf
x_break[] += width;   x_size[] += surface_size;
y_break[] += height;  y_size[] += surface_size;

// ---- each interval becomes one or two graded segments: end point, elements, ratio from left to right
Macro Grade
  segment_end[] = {breaks[0]};  segment_count[] = {};  segment_ratio[] = {};
  For i In {0 : #breaks[] - 2}
    from = breaks[i];  to = breaks[i + 1];  fine_from = sizes[i];  fine_to = sizes[i + 1];
    pieces = (fine_from > 0 && fine_to > 0) ? 2 : 1;
    For piece In {1 : pieces}
      length = (to - from) / pieces;
      fine = (piece == 1 && fine_from > 0) ? fine_from : fine_to;
      If (fine <= 0)
        fine = length / 4;
      EndIf
      count = Ceil(Log(1 + length * (growth - 1) / fine) / Log(growth) - 1e-6);
      ratio = (piece == 1 && fine_from > 0) ? growth : 1 / growth;
      segment_end[] += from + piece * length;
      segment_count[] += count;
      segment_ratio[] += ratio;
    EndFor
  EndFor
Return

breaks[] = x_break[];  sizes[] = x_size[];
Call Grade;
x_end[] = segment_end[];  x_count[] = segment_count[];  x_ratio[] = segment_ratio[];
breaks[] = y_break[];  sizes[] = y_size[];
Call Grade;
y_end[] = segment_end[];  y_count[] = segment_count[];  y_ratio[] = segment_ratio[];
nx = #x_count[];  ny = #y_count[];

// ---- points, lines and cells of the coarse grid, numbered row by row
For j In {0 : ny}
  For i In {0 : nx}
    Point(1 + i + j * (nx + 1)) = {x_end[i], y_end[j], 0};
  EndFor
EndFor
first_vertical = 1 + nx * (ny + 1);
For j In {0 : ny}
  For i In {0 : nx - 1}
    Line(1 + i + j * nx) = {1 + i + j * (nx + 1), 2 + i + j * (nx + 1)};
    Transfinite Curve{1 + i + j * nx} = x_count[i] + 1 Using Progression x_ratio[i];
  EndFor
EndFor
For j In {0 : ny - 1}
  For i In {0 : nx}
    Line(first_vertical + i + j * (nx + 1)) = {1 + i + j * (nx + 1), 1 + i + (j + 1) * (nx + 1)};
    Transfinite Curve{first_vertical + i + j * (nx + 1)} = y_count[j] + 1 Using Progression y_ratio[j];
  EndFor
EndFor
For j In {0 : ny - 1}
  For i In {0 : nx - 1}
    cell = 1 + i + j * nx;
    corner = 1 + i + j * (nx + 1);
    Curve Loop(cell) = {cell, first_vertical + i + 1 + j * (nx + 1), -(cell + nx), -(first_vertical + i + j * (nx + 1))};
    Plane Surface(cell) = {cell};
    If (x_end[i] + x_end[i + 1] < width)
      Transfinite Surface{cell} = {corner, corner + 1, corner + nx + 2, corner + nx + 1} Left;
    Else
      Transfinite Surface{cell} = {corner, corner + 1, corner + nx + 2, corner + nx + 1} Right;
    EndIf
  EndFor
EndFor

Physical Curve("bottom", 1) = {1 : nx};
Physical Curve("right", 2) = {first_vertical + nx : first_vertical + nx + (ny - 1) * (nx + 1) : nx + 1};
Physical Curve("top", 3) = {1 + ny * nx : nx + ny * nx};
Physical Curve("left", 4) = {first_vertical : first_vertical + (ny - 1) * (nx + 1) : nx + 1};
Physical Surface("tissue", 10) = {1 : nx * ny};
