#!/bin/sh
# A sweep by GNU parallel, on this machine or, with --sshloginfile in the variable PARALLEL, on
# machines that see the same folder.
#     parallel.sh FOLDER SHARDS drape reproduce …
# JOBS is the number of shards at a time, CPUS the number of processors of each, ROUNDS how often
# what is missing is started.
set -eu
. "$(dirname "$0")/sweep.sh"

submit() {
    shift
    missing | parallel --jobs "${JOBS:-100%}" --quote \
        env SHARD={} CPUS="${CPUS:-1}" "$shard" "$folder" "$shards" "$@"
}

sweep "$@"
