# The first argument is the shard of the element with index 0.
first=$1
shard=$((first + SLURM_ARRAY_TASK_ID))
restarts=${SLURM_RESTART_COUNT:-0}
say() { echo "$(date '+%F %T') shard $shard of $shards: $*"; }

say "on ${SLURMD_NODENAME:-$(hostname)}, started again $restarts times"
if [ ! -f "$study" ]; then
    say "$PWD has no $study; submit from a directory that the nodes have, too"
    exit 1
fi

# Slurm sends USR1 before the time is over, and TERM when the job is cancelled; TERM it mostly sends
# to the program as well, which takes two within two seconds for one.
child=
signal=
pass_on() {
    signal=$1
    [ -z "$child" ] || kill -s "$signal" "$child" 2>/dev/null || true
}
trap 'pass_on USR1' USR1
trap 'pass_on TERM' TERM

# The store lies on the node's own disk. What is in the export is not computed again.
unset TRIBOSWEEP_STORE
if [ ! -d "${TMPDIR:-}" ] || [ ! -w "${TMPDIR:-}" ]; then
    TMPDIR=/tmp
fi
export TMPDIR
export RAYON_NUM_THREADS="${SLURM_CPUS_PER_TASK:-1}"

# A shard of which no job ends within the time would be queued again in vain. Each stint that runs
# out of time leaves how many before it were in vain, and how far the shard was when it began.
most_in_vain=3
in_vain=0
stints=log/stints.$shard
name=${study##*/}
export_file=$exports/${name%.toml}.$shard-of-$shards.tribosweep
progress() {
    if [ ! -f "$export_file" ]; then
        echo '0 jobs certified, 0 failed'
    elif ! "$program" status --store "$export_file" 2>/dev/null | grep -Eo '^[0-9]+ jobs? certified, [0-9]+ failed'; then
        # What is not known does not count.
        echo "unknown $restarts"
    fi
}
begun=$(progress)
if [ "$restarts" -gt 0 ] && [ -f "$stints" ]; then
    { read -r in_vain && read -r before; } <"$stints" || before=
    if [ "$begun" = "$before" ]; then
        in_vain=$((in_vain + 1))
    else
        in_vain=0
    fi
fi
# A node that dies, or a stint that others cut short, begins to count anew.
rm -f "$stints"
if [ "$in_vain" -ge "$most_in_vain" ]; then
    say "is not finished, and no job ended within the time, $in_vain times in a row: give more --time"
    exit 75
fi

set -- run "$study" --shard "$shard/$shards" --export "$exports" \
    --workers "${SLURM_CPUS_PER_TASK:-1}"

# A tenth of the memory [MiB] is left to the coordinator.
memory=${SLURM_MEM_PER_NODE:-$((${SLURM_MEM_PER_CPU:-0} * ${SLURM_CPUS_PER_TASK:-1}))}
if [ "$memory" -gt 0 ]; then
    set -- "$@" --memory "$((memory * 9 / 10))MiB"
fi

"$program" "$@" &
child=$!
# The signal may have come before there was anybody to pass it on to.
[ -z "$signal" ] || pass_on "$signal"
while :; do
    code=0
    wait "$child" || code=$?
    # A signal ends the waiting, not the program.
    kill -0 "$child" 2>/dev/null || break
done
# The program may have been stopped before it could listen.
if [ -n "$signal" ] && [ "$code" -gt 128 ] && [ "$code" -ne 130 ]; then
    code=75
fi

# A job that Slurm ends is queued again if its time was over. One that was cancelled could be, too,
# and nobody wants that.
job=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
is_wanted() {
    local pause state
    for pause in 1 3 6 0; do
        if state=$(scontrol show job "$job"); then
            grep -Eq 'JobState=RUNNING|Reason=TimeLimit' <<<"$state"
            return
        fi
        sleep "$pause"
    done
    say "does not learn from the controller whether it was cancelled"
}
queue_again() {
    local pause
    for pause in 2 5 0; do
        ! scontrol requeue "$job" || return 0
        sleep "$pause"
    done
    return 1
}
if [ "$code" -ne 75 ]; then
    say "ends with $code"
elif ! is_wanted; then
    say "is not finished, and was cancelled"
elif [ "$restarts" -ge "$most_restarts" ]; then
    say "is not finished, and was started again $restarts times already, which is the most"
else
    say "is not finished, and queues again"
    # Without this file the stint counts for one that was of use.
    printf '%s\n' "$in_vain" "$begun" >"$stints" || true
    if queue_again; then
        # It is pending again, and the end of this script counts for nothing.
        exit 0
    fi
    say "could not be queued again; submit it by: sbatch --array=$SLURM_ARRAY_TASK_ID array.sh $first"
fi
exit "$code"
