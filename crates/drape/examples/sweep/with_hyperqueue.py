#!/usr/bin/env python3
"""A sweep as a HyperQueue job (`pip install hyperqueue`).

    with_hyperqueue.py [--local] [--server DIR] [--cpus N] [--rounds N] \
        FOLDER SHARDS drape reproduce ...

The job goes to the server whose directory is DIR, or the usual one, and its workers must see the
folder. With --local this script starts a server and a worker on this machine, and stops them at
the end. What is missing is submitted again, at most --rounds times; then the parts are merged into
FOLDER/results. The exit code is that of `drape merge`: 4 where cells are missing.
"""

import argparse
import pathlib
import subprocess
import sys

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.ffi.protocol import ResourceRequest


def sweep(client, folder, arguments):
    """Submits what is missing and merges."""
    script = pathlib.Path(__file__).resolve().parent / "shard.sh"
    shards = range(1, arguments.shards + 1)
    for number in range(1, arguments.rounds + 1):
        missing = [i for i in shards if not (folder / f"part-{i}" / "done").exists()]
        if not missing:
            break
        print(f"round {number}: {len(missing)} of {arguments.shards} shards", file=sys.stderr)
        job = Job(max_fails=len(missing))
        for i in missing:
            job.program(
                [str(script), str(folder), str(arguments.shards), *arguments.command],
                env={"SHARD": str(i), "CPUS": str(arguments.cpus)},
                stdout=None,
                stderr=folder / f"shard-{i}.log",
                name=f"shard-{i}",
                resources=ResourceRequest(cpus=arguments.cpus),
            )
        if not client.wait_for_jobs([client.submit(job)], raise_on_error=False):
            print(f"round {number}: some shards failed", file=sys.stderr)
    parts = [str(folder / f"part-{i}") for i in shards if (folder / f"part-{i}").exists()]
    merge = [arguments.command[0], "merge", str(folder / "results"), *parts]
    return subprocess.run(merge, check=False).returncode


def main():
    parser = argparse.ArgumentParser(description="A sweep of drape as a HyperQueue job")
    parser.add_argument("--local", action="store_true", help="start a server and a worker here")
    parser.add_argument("--server", help="directory of the server")
    parser.add_argument("--cpus", type=int, default=1, help="processors of a shard")
    parser.add_argument("--rounds", type=int, default=3, help="how often what is missing is run")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("shards", type=int)
    parser.add_argument("command", nargs=argparse.REMAINDER, help="drape reproduce ...")
    arguments = parser.parse_args()
    if len(arguments.command) < 2:
        parser.error("a command is missing: drape reproduce ...")
    arguments.folder.mkdir(parents=True, exist_ok=True)
    folder = arguments.folder.resolve()
    if arguments.local:
        with LocalCluster() as cluster:
            cluster.start_worker()
            return sweep(cluster.client(), folder, arguments)
    return sweep(Client(arguments.server), folder, arguments)


if __name__ == "__main__":
    sys.exit(main())
