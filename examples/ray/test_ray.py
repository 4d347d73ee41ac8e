#!/usr/bin/env python3
"""Kills a worker, and a program, in the middle of a batch on a local Ray cluster
of two nodes: nothing may be lost, and all bits must be those of a plain run.

    SUPERFORM=path/to/superform python3 test_ray.py

Works on Linux, where /proc tells who is whose child.
"""

import csv
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

import ray
from ray.cluster_utils import Cluster

SHAPES = 12
PATIENCE = 300.0
HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = os.environ.get("SUPERFORM", "superform")
SETTINGS = ["--points", "1500", "--iterations", "20", "--clusters", "12"]


def write_shape(path, number):
    """A ball on a rod, a little different for each number."""
    lines = []
    for i in range(900):
        z = 1 - 2 * (i + 0.5) / 900
        angle, radius = 2.399963 * i, math.sqrt(1 - z * z)
        lines.append(f"{radius * math.cos(angle)} {radius * math.sin(angle)} {z + 3 + 0.1 * number}\n")
        lines.append(f"{0.3 * math.cos(angle)} {0.3 * math.sin(angle)} {2 * i / 900}\n")
    path.write_text("".join(lines))


def programs_at(folder):
    """Processes of the program that write to a folder, with their parents."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
            status = (entry / "status").read_text()
        except (OSError, ValueError):
            continue  # Not a process, or gone.
        if b"--lines" in words and os.fsencode(folder) in words and "State:\tZ" not in status:
            parent = next(line for line in status.splitlines() if line.startswith("PPid:"))
            found.append((int(entry.name), int(parent.split()[1])))
    return found


def finished(folder):
    return len(list(folder.glob("*/job.json"))) if folder.is_dir() else 0


def kill_one(folder, script, jobs, with_worker):
    """Once so many jobs are done, kills a program, and its worker if wanted."""
    start = time.monotonic()
    while True:
        assert time.monotonic() - start < PATIENCE, f"{jobs} jobs were never done"
        assert script.poll() is None, "the batch ended before anything could be killed"
        running = programs_at(folder)
        if finished(folder) >= jobs and running:
            child, parent = running[0]
            try:
                if with_worker:
                    os.kill(parent, signal.SIGKILL)
                os.kill(child, signal.SIGKILL)
            except ProcessLookupError:
                continue  # It has just ended by itself.
            print(f"killed {'worker and program' if with_worker else 'a program'} after {jobs} jobs", flush=True)
            return
        time.sleep(0.005)


def main():
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        manifest = folder / "jobs.csv"
        with manifest.open("w", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(["input", "seed"])
            for number in range(SHAPES):
                write_shape(folder / f"shape {number}.xyz", number)
                rows.writerow([f"shape {number}.xyz", number + 1])
        plain, out = folder / "plain", folder / "results"
        subprocess.run([PROGRAM, "run", "--manifest", manifest, "-o", plain, "-q", *SETTINGS], check=True)

        # Two nodes with a core each.
        cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
        cluster.add_node(num_cpus=1)
        try:
            script = subprocess.Popen(
                [sys.executable, HERE / "superform_ray.py", manifest, "-o", out, "--workers", "2", "--chunk", "3",
                 "--superform", PROGRAM, "--address", cluster.address, "--", *SETTINGS])
            kill_one(out, script, 2, with_worker=True)
            kill_one(out, script, 5, with_worker=False)
            status = script.wait(timeout=PATIENCE)
        finally:
            cluster.shutdown()
        assert status == 0, f"the batch ended with status {status}"

        names = [f"shape {number}" for number in range(SHAPES)]
        for name in names:
            for file in ("primitives.json", "segmented.ply"):
                assert (out / name / file).read_bytes() == (plain / name / file).read_bytes(), f"{name}/{file}"
        with (out / "results.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert [row["name"] for row in rows] == names, rows
        assert {row["status"] for row in rows} == {"ok"}, rows
        assert not (out / ".superform").exists(), "leftovers of the killed"
    print(f"{SHAPES} shapes on two nodes, ray {ray.__version__}: all there, all bits the same")


if __name__ == "__main__":
    main()
