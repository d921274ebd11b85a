#!/bin/sh
# Computes one shard and notes that it is done:
#     shard.sh FOLDER SHARDS drape reproduce …
# The number of the shard comes from the scheduler.
set -eu
i=${SHARD:-${SLURM_ARRAY_TASK_ID:?no number of a shard}}
part=$1/part-$i
shards=$2
shift 2
# A shard is one of many: it takes the processors that the scheduler gave it, by default one.
export RAYON_NUM_THREADS="${SLURM_CPUS_PER_TASK:-${CPUS:-1}}"
"$@" --shard "$i/$shards" --out "$part"
touch "$part/done"
