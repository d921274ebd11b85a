#!/bin/sh
# A sweep as a Slurm job array. The folder must be seen by all nodes.
#     slurm.sh FOLDER SHARDS drape reproduce …
# SBATCH_PARTITION, SBATCH_TIMELIMIT and the like are read by sbatch itself. CPUS is the number of
# processors of a shard, ROUNDS how often what is missing is submitted.
set -eu
. "$(dirname "$0")/sweep.sh"

submit() {
    list=$1
    shift
    sbatch --wait --array="$list" --cpus-per-task="${CPUS:-1}" --requeue \
        --output="$folder/shard-%a.log" "$shard" "$folder" "$shards" "$@"
}

sweep "$@"
