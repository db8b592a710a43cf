#!/bin/bash
# A study on a cluster: Debian's Slurm and munge, started here with two nodes on this machine and separate ports. Every
# load path is a step, also in space. A killed step and a requeued job lose no result. The results equal those of a run
# without Slurm.
. "$(dirname "$0")/common"
for program in munged slurmctld slurmd sbatch srun scancel scontrol squeue; do
    PATH=$PATH:/usr/sbin command -v $program >/dev/null || {
        skip "a study is solved through Slurm" "$program is not installed (scripts/install_deps test)"
        finish
    }
done
PATH=$PATH:/usr/sbin
patience=180
cluster=$scratch/cluster
host=$(hostname -s)
export SLURM_CONF=$cluster/slurm.conf

# ---- the cluster
daemons=
tear_down() {
    [ -z "${job-}" ] || timeout 10 scancel --full "$job" 2>/dev/null
    # shellcheck disable=SC2086  # process ids are separate words
    [ -z "$daemons" ] || { kill $daemons; sleep 0.5; kill -9 $daemons; wait $daemons; } 2>/dev/null
    clean_up
}
trap tear_down EXIT

daemon() { # NAME COMMAND...: runs it as a child in the foreground, so its process id is known
    name=$1
    shift
    "$@" >"$cluster/$name.out" 2>&1 </dev/null &
    daemons="$! $daemons"
}

start_cluster() {
    mkdir -p "$cluster/munge" "$cluster/state" || return 1
    chmod 755 "$scratch" "$cluster"
    head -c 128 /dev/urandom >"$cluster/munge/key" && chmod 400 "$cluster/munge/key"
    as_munge=
    if [ "$(id -u)" = 0 ]; then
        chown -R munge: "$cluster/munge"
        as_munge="setpriv --reuid=munge --regid=munge --clear-groups"
    fi
    # shellcheck disable=SC2086
    daemon munged $as_munge munged --foreground --key-file="$cluster/munge/key" --socket="$cluster/munge/socket" \
        --pid-file="$cluster/munge/pid" --seed-file="$cluster/munge/seed" --log-file="$cluster/munge/log"
    read -r port1 port2 port3 <<<"$("$PYTHON" -c 'import socket
sockets = [socket.socket() for _ in range(3)]
for s in sockets: s.bind(("127.0.0.1", 0))
print(*(s.getsockname()[1] for s in sockets))')"
    cat >"$SLURM_CONF" <<CONF
ClusterName=scratch
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port1
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$cluster/munge/socket
CredType=cred/munge
StateSaveLocation=$cluster/state
SlurmdSpoolDir=$cluster/spool-%n
SlurmctldPidFile=$cluster/slurmctld.pid
SlurmdPidFile=$cluster/%n.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0
KillWait=2
NodeName=one NodeHostname=$host NodeAddr=127.0.0.1 Port=$port2 CPUs=1 RealMemory=2000
NodeName=two NodeHostname=$host NodeAddr=127.0.0.1 Port=$port3 CPUs=1 RealMemory=2000
PartitionName=all Nodes=ALL Default=YES State=UP
CONF
    wait_for test -S "$cluster/munge/socket" || return 1
    daemon slurmctld slurmctld -D
    daemon one slurmd -D -N one
    daemon two slurmd -D -N two
    wait_for two_idle
}
two_idle() { [ "$(timeout 60 sinfo -h -t idle -o %D 2>/dev/null)" = 2 ]; }
if ! start_cluster; then
    skip "a study is solved through Slurm" "Slurm did not start: $(tail -qn 1 "$cluster"/*.out | tr '\n' ' ')"
    finish
fi

# ---- a study of four load paths. The substitute for FreeFEM notes its step, and waits with a load path while hold/
# contains a file of its name, so a step that is to be killed is running even on a busy machine.
make_copy
edit '^  { name = "top".*' '&\n  { name = "right", contact_m = [0.10, 0.05], push = [-1, -0.5] },\n  { name = "corner", contact_m = [0.10, 0.10], push = [-1, -1] },'
make_tiny eval -j2
check "the study is solved without Slurm" exited 0
cp -R "$R" "$scratch/local"

mkdir "$scratch/slow" "$scratch/hold"
cat >"$scratch/slow/FreeFem++-nw" <<SH
#!/bin/sh
for word; do case \$word in */cases/*.csv.tmp) path=\${word##*/} ;; esac; done
path=\${path%.csv.tmp}
echo "\$SLURM_JOB_ID.\$SLURM_STEP_ID \$SLURMD_NODENAME \$path" >>"$scratch/steps"
while [ -e "$scratch/hold/\$path" ]; do sleep 0.1; done
exec $(command -v FreeFem++-nw) "\$@"
SH
chmod +x "$scratch/slow/FreeFem++-nw"

submit() { # STUDY TARGET: submits it with an empty results folder; its job id is in $job
    rm -rf "$work/results/$1"
    : >"$scratch/steps"
    job=$(cd "$work" && PATH=$scratch/slow:$PATH sbatch --parsable --nodes=2 --output="$said" scripts/slurm/study.sbatch "$1" "$2")
}
state() { scontrol show job "$job" | sed -n 's/.*JobState=\([A-Z]*\).*/\1/p'; }
ended() { case $(state) in COMPLETED | FAILED | CANCELLED | TIMEOUT | NODE_FAIL) ;; *) return 1 ;; esac; }  # an empty state is not an end
completed() { [ "$(state)" = COMPLETED ] || { state; tail -n 3 "$cluster/slurmctld.out"; cat "$said"; return 1; }; }
begun() { [ "$(wc -l <"$scratch/steps")" -ge "$1" ]; }
solved() { [ -s "$R/cases/$1.csv" ]; }
times() { grep -c " $1\$" "$scratch/steps"; }  # number of starts of a load path

kill_step() { # PATH: kills the step that solves it, then releases the load path
    wait_for grep -q " $1\$" "$scratch/steps"
    step=$(sed -n "s/ .* $1\$//p" "$scratch/steps")
    scancel "$step"
    wait_for gone
    rm "$scratch/hold/$1"
}
gone() { ! squeue --steps --noheader --format=%i | grep -qx "$step"; }

# ---- one step is killed while it runs
touch "$scratch/hold/left"
submit tiny eval
kill_step left
wait_for ended
check "a job completes although one of its steps was killed" completed
check "the load path of the killed step is solved again" test "$(times left)" = 2
check "no other load path is solved again" test "$(times top) $(times right) $(times corner)" = "1 1 1"
check "the output names the failed load path and the second try" sh -c "grep -q 'cases/left.csv' '$said' && grep -q 'try 2' '$said'"
check "every load path is a separate step" test "$(cut -d' ' -f1 "$scratch/steps" | sort -u | grep -c "^$job\.[0-9]")" = 5
check "both nodes run steps" test "$(cut -d' ' -f2 "$scratch/steps" | sort -u | tr '\n' ' ')" = "one two "
check "the results equal those without Slurm" same_contents "$R" "$scratch/local"
check "no incomplete file is left" no_half_files "$R"

# ---- a job is killed half-way and requeued
touch "$scratch/hold/top" "$scratch/hold/right" "$scratch/hold/corner"
submit tiny eval
wait_for solved left
wait_for begun 3  # the first two load paths of a job of two tasks, and the one after `left`
# Slurm stores the times of a job's credential and of its revocation in whole seconds. A job that starts again in the
# second in which it was killed is refused by its nodes and fails. A requeued job therefore waits for the lifetime of a
# credential, two minutes. This test waits only for the next second. A job that is pending again is not killed any more.
refusals() { grep -c "Killing non-startable batch JobId=$job:" "$cluster/slurmctld.out"; }
queued() { [ "$(state)" = PENDING ]; }
started_or_ended() { begun 4 || ended; }  # 4: one more than before
start_again() {
    for try in 1 2 3; do
        refused=$(refusals)
        scontrol requeue "$job" && wait_for queued || return 1
        sleep 2
        scontrol update JobId="$job" StartTime=now && wait_for started_or_ended || return 1
        if begun 4; then return; fi
        [ "$(refusals)" -gt "$refused" ] || break  # only a refused start is tried again
    done
    echo "job $job is $(state) after $try tries; slurmctld:"
    tail -n 5 "$cluster/slurmctld.out"
    return 1
}
check "a job that is killed half-way and requeued starts again" start_again
rm "$scratch/hold"/*
wait_for ended
check "a requeued job completes" completed
check "a requeued job does not solve finished load paths again" test "$(times left)" = 1
check "the results of a requeued job equal those without Slurm" same_contents "$R" "$scratch/local"

# ---- a solid: every step makes a mesh beside its CSV; one step is killed after its mesh is made
solid_study >"$work/fem/studies/solid.toml"
R=$work/results/solid
run make PYTHON="$PYTHON" STUDY=solid eval -j2
check "a solid's study is solved without Slurm" exited 0
cp -R "$R" "$scratch/solid"
killed=validation-0001
touch "$scratch/hold/$killed"
submit solid eval
kill_step $killed
wait_for ended
check "a solid's job completes although a step was killed between its mesh and its CSV" completed
check "only the load path of the killed step is solved again" test "$(times $killed) $(wc -l <"$scratch/steps")" = "2 8"
check "every load path of the solid is a separate step" test "$(cut -d' ' -f1 "$scratch/steps" | sort -u | grep -c "^$job\.[0-9]")" = 8
check "a solid's results equal those without Slurm" same_contents "$R" "$scratch/solid"
check "no temporary mesh of the solid is left" no_half_files "$R"
finish
