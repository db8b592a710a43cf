#!/bin/bash
# kill -9 of `make all` in the plane, the whole process group, at twenty seeded moments: it resumes, redoes no finished load path, leaves
# nothing half-written, and ends with the same contents of every dataset as a run that nobody killed.
. "$(dirname "$0")/common"
. "$(dirname "$0")/kills"
make_copy

# FE that takes its time: three paths on a finer mesh, so that kills find it at work
edit '^record_step_m = .*' 'record_step_m = 0.001'
edit '^  { name = "top".*' '&\n  { name = "right", contact_m = [0.10, 0.05], push = [-1, -0.5] },'
edit '^refine = 1' 'refine = 4'

undisturbed tiny
kill_make tiny 4 5
finish_kills "make all of a study in the plane"
