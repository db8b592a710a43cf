#!/bin/bash
# kill -9 of `make all` in the plane, of the whole process group, at twenty times drawn by a seed. It resumes, solves no
# finished load path again, leaves no incomplete file, and ends with the same datasets as an undisturbed run.
. "$(dirname "$0")/common"
. "$(dirname "$0")/kills"
make_copy

# Longer finite elements, so that kills hit them: three load paths on a finer mesh.
edit '^record_step_m = .*' 'record_step_m = 0.001'
edit '^  { name = "top".*' '&\n  { name = "right", contact_m = [0.10, 0.05], push = [-1, -0.5] },'
edit '^refine = 1' 'refine = 4'

undisturbed tiny
kill_make tiny 4 5
finish_kills "make all of a study in the plane"
