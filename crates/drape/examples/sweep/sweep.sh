# What the scripts beside this one share. They source it as
#     . sweep.sh FOLDER SHARDS drape reproduce …
# and define `submit LIST`, which computes the shards of a list such as 1-3,7 and waits for them.
#
# FOLDER/part-I belongs to shard I. A file `done` in it says that the shard has ended well.

if [ $# -lt 4 ]; then
    echo "usage: $0 FOLDER SHARDS drape reproduce [OPTIONS]   (or: drape experiment NAME …)" >&2
    exit 2
fi
mkdir -p "$1"
folder=$(cd "$1" && pwd)
shards=$2
shift 2
shard=$(cd "$(dirname "$0")" && pwd)/shard.sh

# Numbers of the shards that are not done, one a line.
missing() {
    for i in $(seq 1 "$shards"); do
        [ -e "$folder/part-$i/done" ] || echo "$i"
    done
}

# Joins numbers, one a line, to ranges: 1-3,7.
ranges() {
    awk 'function put() { list = list (list == "" ? "" : ",") (a == b ? a : a "-" b) }
        NR == 1 { a = b = $1; next }
        $1 == b + 1 { b = $1; next }
        { put(); a = b = $1 }
        END { if (NR) put(); print list }'
}

# Submits what is missing, at most ROUNDS times, and merges the parts into FOLDER/results. The exit
# code is that of the merge: 4 where cells are missing.
sweep() {
    round=1
    while list=$(missing | ranges) && [ -n "$list" ] && [ "$round" -le "${ROUNDS:-3}" ]; do
        echo "round $round: shards $list of $shards" >&2
        submit "$list" "$@" || echo "round $round: some shards failed" >&2
        round=$((round + 1))
    done
    "$1" merge "$folder/results" "$folder"/part-*
}
