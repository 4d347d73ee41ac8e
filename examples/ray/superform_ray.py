#!/usr/bin/env python3
"""Abstracts the shapes of a list on a Ray cluster, with Superform's command line
as the unit of work.

    superform_ray.py jobs.csv -o results --workers 8 -- --alpha 0.3

A task does a few lines of the list (`superform run --lines A..B`). What a task
finishes is on disk for good; a task whose process, worker or machine is killed
is done again by Ray, and finds there what was finished. At the end all results
are in one table. The same command again does only what is not finished.

All machines must see the list, the shapes and the folder of the results under
the same paths, and have the program. What follows -- is for `superform run`.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys

import ray

# Exit statuses of `superform run`: 10 + n where n jobs failed for good, because
# of their input. Nothing is gained by doing these again.
FAILED_JOBS = range(11, 111)


def count_jobs(manifest):
    """The number of jobs in a list: rows of CSV below the header, or JSON lines.

    One too many does no harm: the program finds nothing to do there.
    """
    text = manifest.read_text(encoding="utf-8-sig")
    if text.lstrip().startswith("{"):
        return sum(1 for line in text.splitlines() if line.strip())
    header = next((line for line in text.splitlines() if line.strip()), "")
    delimiter = max("\t;,", key=header.count)
    rows = csv.reader(text.splitlines(keepends=True), delimiter=delimiter)
    return max(sum(1 for row in rows if any(cell.strip() for cell in row)) - 1, 0)


def chunks(jobs, size):
    """Parts of the list as (first, last), counted from 1, both ends belonging to it."""
    return [(first, min(first + size - 1, jobs)) for first in range(1, jobs + 1, size)]


class Interrupted(Exception):
    """The program ended before it was done: it was killed, or told to stop."""


def abstract(command, first, last):
    """Does some lines of the list; returns the exit status."""
    status = subprocess.run([*command, "--lines", f"{first}..{last}"], check=False).returncode
    if status not in (0, 1, 2) and status not in FAILED_JOBS:
        raise Interrupted(f"lines {first} to {last}: the program ended with status {status}")
    return status


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("manifest", type=pathlib.Path, help="list of jobs: CSV with a header, or JSON lines")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="folder for the results")
    parser.add_argument("--workers", type=int, default=None, metavar="N",
                        help="tasks at a time [default: one a core of the cluster]")
    parser.add_argument("--chunk", type=int, default=8, metavar="N", help="lines a task [default: %(default)s]")
    parser.add_argument("--retries", type=int, default=5, metavar="N",
                        help="how often a task is done again that was killed [default: %(default)s]")
    parser.add_argument("--superform", default="superform", metavar="PROGRAM", help="the program")
    parser.add_argument("--address", default=None, help="the cluster; without it, one is started on this machine")
    end = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    args, settings = parser.parse_args(sys.argv[1:end]), sys.argv[end + 1:]

    manifest, output = args.manifest.resolve(), args.output.resolve()
    run = [args.superform, "run", "--manifest", str(manifest), "-o", str(output), *settings]
    command = [*run, "--quiet", "--jobs", "1"]
    parts = chunks(count_jobs(manifest), max(args.chunk, 1))

    if args.address is None:
        ray.init(num_cpus=args.workers, include_dashboard=False)
    else:
        ray.init(address=args.address)
    task = ray.remote(num_cpus=1, max_retries=args.retries, retry_exceptions=[Interrupted])(abstract)
    waiting, running = list(parts), []
    limit = args.workers or max(int(ray.cluster_resources().get("CPU", 1)), 1)
    broken = 0
    while waiting or running:
        while waiting and len(running) < limit:
            running.append(task.remote(command, *waiting.pop(0)))
        ready, running = ray.wait(running)
        for result in ready:
            try:
                status = ray.get(result)
            except (Interrupted, ray.exceptions.RayError) as error:
                # Given up after all retries; the others go on.
                print(f"a task was given up: {error}", file=sys.stderr)
                broken += 1
            else:
                broken += status in (1, 2)
    ray.shutdown()

    merged = subprocess.run([args.superform, "merge-results", str(output)], check=False).returncode
    if broken:
        print(f"{broken} tasks were not done; the same command does what is not finished", file=sys.stderr)
        return 1
    return merged


if __name__ == "__main__":
    sys.exit(main())
