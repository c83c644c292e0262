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

# The store lies on the node's own disk. What is in the export is not computed again.
unset TRIBOSWEEP_STORE
if [ ! -d "${TMPDIR:-}" ] || [ ! -w "${TMPDIR:-}" ]; then
    TMPDIR=/tmp
fi
export TMPDIR
export RAYON_NUM_THREADS="${SLURM_CPUS_PER_TASK:-1}"
set -- run "$study" --shard "$shard/$shards" --export "$exports" \
    --workers "${SLURM_CPUS_PER_TASK:-1}"

# A tenth of the memory [MiB] is left to the coordinator.
memory=${SLURM_MEM_PER_NODE:-$((${SLURM_MEM_PER_CPU:-0} * ${SLURM_CPUS_PER_TASK:-1}))}
if [ "$memory" -gt 0 ]; then
    set -- "$@" --memory "$((memory * 9 / 10))MiB"
fi

# Slurm sends USR1 before the time is over, and TERM when the job is cancelled.
child=
signal=
pass_on() {
    signal=$1
    [ -z "$child" ] || kill -s "$signal" "$child" 2>/dev/null || true
}
trap 'pass_on USR1' USR1
trap 'pass_on TERM' TERM
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
is_wanted() { scontrol show job "$job" | grep -Eq 'JobState=RUNNING|Reason=TimeLimit'; }
if [ "$code" -ne 75 ]; then
    say "ends with $code"
elif ! is_wanted; then
    say "is not finished, and was cancelled"
elif [ "$restarts" -ge "$most_restarts" ]; then
    say "is not finished, and was started again $restarts times already, which is the most"
else
    say "is not finished, and queues again"
    if scontrol requeue "$job"; then
        # It is pending again, and the end of this script counts for nothing.
        exit 0
    fi
    say "could not be queued again; submit it by: sbatch --array=$SLURM_ARRAY_TASK_ID array.sh $first"
fi
exit "$code"
