# A Slurm of one node on this machine, for a test: everything it writes is in the scratch folder. Sourced after common.sh.
# shellcheck shell=bash disable=SC2154

need munged slurmctld slurmd sbatch scontrol squeue
[[ $(id -u) == 0 ]] || fail "Slurm is started as root here"

# Its own folder has a plain name, as Slurm's configuration cannot quote.
slurm=$(mktemp -d "${TMPDIR:-/tmp}/perirobot-slurm.XXXXXX")
export SLURM_CONF="$slurm/slurm.conf"

# A port that nothing uses, as far as one can know.
free_port() {
    local port
    for port in $(shuf -i 20000-32000 -n 50); do
        (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || { echo "$port" && return; }
    done
    fail "no free port"
}

configure_slurm() {
    local host
    host=$(hostname -s)
    mkdir "$slurm/state" "$slurm/spool"
    cat >"$SLURM_CONF" <<END
ClusterName=perirobot
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
# What is put back into the queue waits for its credential to end: 2 minutes, were it not said.
AuthInfo=socket=$slurm/munge.socket,cred_expire=5
StateSaveLocation=$slurm/state
SlurmdSpoolDir=$slurm/spool
SlurmctldPidFile=$slurm/slurmctld.pid
SlurmdPidFile=$slurm/slurmd.pid
SlurmctldLogFile=$slurm/slurmctld.out
SlurmdLogFile=$slurm/slurmd.out
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
# When the node says that it runs a task no longer, Slurm believes it for tasks older than these together.
BatchStartTimeout=1
MessageTimeout=5
# More processors than there may be, so that the shards run side by side.
SlurmdParameters=config_overrides
NodeName=$host NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
}

start_slurm() {
    at_end+=(stop_slurm)
    configure_slurm
    (umask 077 && head -c 1024 /dev/urandom >"$slurm/munge.key")
    munged --force --key-file="$slurm/munge.key" --socket="$slurm/munge.socket" --pid-file="$slurm/munged.pid" \
        --log-file="$slurm/munged.out" --seed-file="$slurm/munged.seed" 2>"$slurm/munged-start.out" ||
        fail "munged does not start: $(<"$slurm/munged-start.out")"
    slurmctld
    within 30 "slurmctld answers" controller_answers
    slurmd
    within 30 "the node is idle" node_is_idle
}

controller_answers() { scontrol ping | grep -q UP; }
node_is_idle() { [[ $(sinfo --noheader --format=%t) == idle ]]; }

# Only what this test started, by the numbers that it wrote down.
stop_slurm() {
    local daemon number
    if (($1 != 0)); then tail -v -n 20 "$slurm"/*.out >&2; fi
    if [[ -e $slurm/slurmctld.pid ]]; then
        scancel --user=root
        for _ in {1..100}; do
            if all_ended; then break; fi
            sleep 0.1
        done
    fi
    for daemon in slurmd slurmctld munged; do
        number=$({ cat "$slurm/$daemon.pid"; } 2>/dev/null) && end "$number"
    done
    rm -rf "$slurm"
}

# submit SCRIPT: runs it; `job` is then the number of its array job.
submit() {
    local said
    said=$(sh "$1")
    say "$said"
    job=$(sed -n 's/^job \([0-9]*\) .*/\1/p' <<<"$said")
    [[ -n $job ]] || fail "no job number in: $said"
}

# The queue is empty: all have ended, the merge, too.
all_ended() { [[ -z $(squeue --noheader) ]]; }

# restarts TASK: how often Slurm has put that task back.
restarts() { scontrol show job "${job}_$1" | sed -n 's/.* Restarts=\([0-9]*\).*/\1/p'; }
