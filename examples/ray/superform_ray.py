#!/usr/bin/env python3
"""Runs a list of shapes on a Ray cluster, with Superform's command line as the
unit of work.

    superform_ray.py jobs.csv -o results --workers 8 -- --alpha 0.3

Each task runs a few lines of the list (`superform run --lines A..B`). Finished
jobs are safely on disk; if a process, worker or machine is killed, Ray repeats
its tasks, which skip finished jobs. At the end, all results are in one table.
Repeating the command runs only unfinished jobs.

All machines must have the program and see the list, the shapes and the output
folder under the same paths. Arguments after -- are passed to `superform run`.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys

import ray

# Exit statuses of `superform run`: 10 + n if n jobs failed because of their
# input. Repeating these does not help.
FAILED_JOBS = range(11, 111)


def count_jobs(manifest):
    """The number of jobs in a list: rows of CSV below the header, or JSON lines.

    Counting one too many is harmless: the program finds nothing to do there.
    """
    text = manifest.read_text(encoding="utf-8-sig")
    if text.lstrip().startswith("{"):
        return sum(1 for line in text.splitlines() if line.strip())
    header = next((line for line in text.splitlines() if line.strip()), "")
    delimiter = max("\t;,", key=header.count)
    rows = csv.reader(text.splitlines(keepends=True), delimiter=delimiter)
    return max(sum(1 for row in rows if any(cell.strip() for cell in row)) - 1, 0)


def chunks(jobs, size):
    """Parts of the list as (first, last), counted from 1, inclusive."""
    return [(first, min(first + size - 1, jobs)) for first in range(1, jobs + 1, size)]


class Interrupted(Exception):
    """The program was killed or stopped before it finished."""


def abstract(command, first, last):
    """Runs some lines of the list; returns the exit status."""
    status = subprocess.run([*command, "--lines", f"{first}..{last}"], check=False).returncode
    if status not in (0, 1, 2) and status not in FAILED_JOBS:
        raise Interrupted(f"lines {first} to {last}: the program ended with status {status}")
    return status


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("manifest", type=pathlib.Path, help="list of jobs: CSV with a header, or JSON lines")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="folder for the results")
    parser.add_argument("--workers", type=int, default=None, metavar="N",
                        help="parallel tasks [default: one per core of the cluster]")
    parser.add_argument("--chunk", type=int, default=8, metavar="N", help="lines per task [default: %(default)s]")
    parser.add_argument("--retries", type=int, default=5, metavar="N",
                        help="how often a killed task is repeated [default: %(default)s]")
    parser.add_argument("--superform", default="superform", metavar="PROGRAM", help="the program")
    parser.add_argument("--address", default=None, help="address of the cluster; without it, a local one is started")
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
                # Failed after all retries; the others continue.
                print(f"a task failed after all retries: {error}", file=sys.stderr)
                broken += 1
            else:
                broken += status in (1, 2)
    ray.shutdown()

    merged = subprocess.run([args.superform, "merge-results", str(output)], check=False).returncode
    if broken:
        print(f"{broken} tasks failed; repeat the command to run unfinished jobs", file=sys.stderr)
        return 1
    return merged


if __name__ == "__main__":
    sys.exit(main())
