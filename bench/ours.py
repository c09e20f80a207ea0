#!/usr/bin/env python3
"""Runs midway once and prints a JSON line as the peers' scripts do, its image beside it as .npy.

usage: ours.py MIDWAY SCENE_NAME SCENE_FILE SECONDS OUT [midway flags...]

Time is the process's CPU seconds over the threads, as for the peers, so that others on the machine
do not count; start-up does. At SECONDS midway is interrupted and writes what it has. Linux only.
"""
import json
import os
import resource
import signal
import subprocess
import sys
import time

import numpy as np
import OpenEXR

THREADS = os.cpu_count()
# The exit code of a render that Ctrl-C ended.
INTERRUPTED = 10


def cpu_seconds(pid):
    """CPU time of a process so far, over the threads."""
    with open(f"/proc/{pid}/stat", encoding="ascii") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK") / THREADS


def read(path):
    with OpenEXR.File(path) as file:
        channels = file.channels()
        if "RGB" in channels:
            return channels["RGB"].pixels.copy()
        return np.stack([channels[name].pixels for name in "RGB"], -1)


def main():
    program, name, scene, seconds, out, *flags = sys.argv[1:]
    size = 256
    command = [program, "render", scene, "--spp", "1000000000", "--width", str(size), "--height", str(size),
               "--device", "cpu", "--progress", "json", "--quiet", "-o", out + ".exr", *flags]
    start = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        while process.poll() is None and cpu_seconds(process.pid) < float(seconds):
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        output = process.communicate()[0]
    if process.returncode != INTERRUPTED:
        sys.exit(f"midway ended with {process.returncode}")
    wall = time.perf_counter() - start
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = (usage.ru_utime + usage.ru_stime) / THREADS
    events = [json.loads(line) for line in output.splitlines()]
    start_event, end = ([e for e in events if e["event"] == kind][-1] for kind in ("start", "end"))
    np.save(out + ".npy", read(out + ".exr").astype(np.float32))
    print(json.dumps({
        "engine": "midway:" + start_event["integrator"].replace(" ", ","), "scene": name,
        "mark": float(seconds), "t": cpu, "wall": wall, "spp": end["samples"], "file": out,
        "msps": end["samples"] * size * size / cpu / 1e6, "mrays": end["mrays_per_second"],
    }))


main()
