#!/usr/bin/env python3
"""A job of bricks on machines that are not here: a simulation by events, with the times of a job that was measured.

  simulate_cluster.py measure JOB --scanknit PROGRAM > job.json   makes each brick of a planned job anew, and joins it
  simulate_cluster.py run job.json --frames 100000 --workers 1,64  what larger jobs would take

JOB is what `scanknit plan RECORDING -o JOB --estimate` made. A larger job is a longer walk: copies of the measured scene, one after
the other, each with bricks drawn from the measured ones. Workers take shares as `scanknit work --workers N` does
(scan/job/brick_job.cpp). Their frames are read ahead while they compute; all share the storage evenly. Times are processor seconds:
each worker has a processor.
"""

import argparse
import heapq
import json
import math
import os
import random
import subprocess
import sys
import tempfile


def spent(command):
    """Processor seconds and peak memory in MiB of a command."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"failed: {' '.join(command)}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def measure(options):
    with open(os.path.join(options.job, "estimate.json")) as file:
        estimate = json.load(file)
    bricks = []
    peak = 0
    order = list(enumerate(estimate["each_brick"]))
    random.Random(1).shuffle(order)  # a machine that becomes slower meanwhile makes no part of the scene slower
    for number, planned in order:
        path = os.path.join(options.job, "bricks", f"{number}.brick")
        if os.path.exists(path):
            os.remove(path)
        seconds, mib = spent([options.scanknit, "work", options.job, "--brick", str(number), "--threads", "1", "--quiet"])
        peak = max(peak, mib)
        bricks.append([number, planned["frames"], planned["blocks"], round(seconds, 3), os.path.getsize(path)])
    with tempfile.TemporaryDirectory() as folder:
        join_s, join_mib = spent([options.scanknit, "join", options.job, "-o", folder, "--quiet"])
    start_s, _ = spent([options.scanknit, "work", options.job, "--quiet"])  # nothing is left to do
    result = {
        "frames": estimate["frames"],
        "plan_s": round(estimate["processor_s"]["plan"], 3),
        "start_s": round(start_s, 3),
        "join_s": round(join_s, 3),
        "join_start_s": round(min(estimate["join_start"]["processor_s"], join_s), 3),
        "frame_bytes": round(estimate["frame"]["bytes"]),
        "worker_mib": round(peak),
        "join_mib": round(join_mib),
        "bricks": [brick[1:] for brick in sorted(bricks)],  # frames, blocks that the plan gives, processor seconds alone, bytes
    }
    json.dump(result, sys.stdout)
    print()


class Storage:
    """Transfers that share a bandwidth evenly, none faster than its own link. `now` only grows."""

    def __init__(self, bandwidth, link):
        self.bandwidth, self.link = bandwidth, link
        self.now = 0.0
        self.moved = 0.0  # of a transfer that began at 0, if it had not ended
        self.active = []  # (what `moved` is when it ends, key)

    def rate(self):
        return min(self.link, self.bandwidth / len(self.active)) if self.active else 0.0

    def go_to(self, now):
        self.moved += (now - self.now) * self.rate()
        self.now = now

    def add(self, key, size):
        heapq.heappush(self.active, (self.moved + size, key))

    def next_end(self):
        if not self.active:
            return float("inf")
        return self.now + max(0.0, self.active[0][0] - self.moved) / self.rate()

    def pop(self):
        return heapq.heappop(self.active)[1]


def frame_cost(job):
    """Seconds a frame, by least squares: a brick alone takes start + a frames + b frames x blocks."""
    ff = fu = uu = fs = us = 0.0
    for frames, blocks, alone_s, _ in job["bricks"]:
        updates, own_s = frames * blocks, alone_s - job["start_s"]
        ff += frames * frames
        fu += frames * updates
        uu += updates * updates
        fs += frames * own_s
        us += updates * own_s
    return max(0.0, (fs * uu - us * fu) / (ff * uu - fu * fu))


class Scene:
    """A long walk, of `frames` frames, in bricks."""

    def __init__(self, job, frames, seed):
        chance = random.Random(seed)
        self.job = job
        self.copies = max(1, round(frames / job["frames"]))
        self.per_copy = len(job["bricks"])
        self.frame_s = frame_cost(job)
        # A group of n bricks reads its frames once: between the frames of one brick and all of the scene's, as a power of n.
        mean = sum(brick[0] for brick in job["bricks"]) / self.per_copy
        self.growth = math.log(job["frames"] / mean) / math.log(self.per_copy) if self.per_copy > 1 else 0
        self.bricks = []
        for _ in range(self.copies):
            if self.copies == 1:
                self.bricks += job["bricks"]
            else:
                self.bricks += [chance.choice(job["bricks"]) for _ in range(self.per_copy)]

    def cost(self, first, last):
        """Processor seconds and bytes of the bricks from `first` to before `last`, made at once. Those of one copy of the scene have
        frames in common."""
        seconds = size = 0.0
        frame_s, frame_bytes = self.frame_s, self.job["frame_bytes"]
        start_s = self.job["start_s"]
        while first < last:
            end = min(last, (first // self.per_copy + 1) * self.per_copy)
            readings = 0
            for frames, _, alone_s, written in self.bricks[first:end]:
                readings += frames
                seconds += alone_s - start_s - frames * frame_s
                size += written
            count = end - first
            read = min(readings, self.job["frames"] * (count / self.per_copy) ** self.growth) if count > 1 else readings
            seconds += read * frame_s
            size += read * frame_bytes
            first = end
        return seconds, size


BLOCK_BYTES = 8200  # of memory


def work_of(brick):
    return brick[0] * brick[1]


def group_end(scene, first, last, most_work, memory_mib):
    """The end of the group that begins with brick `first`: so much work, as far as the memory allows."""
    room = memory_mib * 2**20
    work = 0
    end = first
    while end < last:
        room -= scene.bricks[end][1] * BLOCK_BYTES
        if end > first and (room < 0 or work + work_of(scene.bricks[end]) / 2 >= most_work):
            break
        work += work_of(scene.bricks[end])
        end += 1
    return end, work


def work(scene, workers, options, seed):
    """Wall time and processor seconds of the step `work`."""
    chance = random.Random(seed)
    count = len(scene.bricks)
    storage = Storage(options.bandwidth * 1e6, options.link * 1e6)
    events = []  # (time, order, what, worker)
    order = 0
    # What nobody took, as intervals; each worker begins at its own share.
    left = sum(map(work_of, scene.bricks))
    share = left / workers
    free = [[0, 0]]
    passed = 0
    for number, brick in enumerate(scene.bricks):
        if int((passed + work_of(brick) / 2) / share) >= len(free):
            free.append([number, number])
        free[-1][1] = number + 1
        passed += work_of(brick)
    busy_s = 0.0
    waiting = {}  # worker: parts of its group that are not over (processor, storage)
    for worker in range(workers):
        heapq.heappush(events, (scene.job["start_s"], order, "free", worker))
        busy_s += scene.job["start_s"]
        order += 1
    slowness = [options.slow_factor if chance.random() < options.slow_share else chance.lognormvariate(0, options.spread)
                for _ in range(workers)]
    end_s = 0.0

    def take(worker, most):
        nonlocal left
        index = worker if worker < len(free) and free[worker][0] < free[worker][1] else None
        if index is None:
            index = next((i for i in range(take.first, len(free)) if free[i][0] < free[i][1]), None)
            if index is None:
                return None
            if index > take.first and all(free[i][0] >= free[i][1] for i in range(take.first, index)):
                take.first = index
        begin, last = free[index]
        end, taken = group_end(scene, begin, last, most, options.memory)
        free[index][0] = end
        left -= taken
        return begin, end

    take.first = 0
    while events or storage.active:
        at = events[0][0] if events else float("inf")
        stored = storage.next_end()
        if stored <= at:
            storage.go_to(stored)
            now, what, worker = stored, "over", storage.pop()
        else:
            now, _, what, worker = heapq.heappop(events)
            storage.go_to(now)
        if what == "over":
            waiting[worker] -= 1
            if waiting[worker] > 0:
                continue
            end_s = max(end_s, now)
        group = take(worker, left / workers if what == "over" else share)
        if group is None:
            continue
        seconds, size = scene.cost(*group)
        busy_s += seconds
        waiting[worker] = 2
        claims_s = (group[1] - group[0]) * 3 * options.metadata * 1e-3  # look, claim, release
        spent_s = seconds * slowness[worker] + claims_s
        if chance.random() < options.lost * spent_s / 3600:  # the worker dies; another one waits for the lease, and does it again
            spent_s = chance.random() * spent_s + 60 + spent_s
        heapq.heappush(events, (now + spent_s, order, "over", worker))
        order += 1
        storage.add(worker, size)
    return end_s, busy_s


def as_measured(job):
    """What `measure` writes, from JOB/estimate.json: the model instead of each brick's own time."""
    if "each_brick" not in job:
        return job
    start_s = job["start"]["processor_s"]
    bricks = [[b["frames"], b["blocks"], start_s + b["processor_s"], b["bytes"]] for b in job["each_brick"]]
    return {"frames": job["frames"], "plan_s": job["processor_s"]["plan"], "start_s": start_s,
            "join_s": job["processor_s"]["join"], "join_start_s": job["join_start"]["processor_s"],
            "frame_bytes": job["frame"]["bytes"], "bricks": bricks}


def simulate(job, frames, workers, options):
    scene = Scene(job, frames, options.seed)
    plan_s = job["plan_s"] * scene.copies
    plan_s = max(plan_s, job["frame_bytes"] * job["frames"] * scene.copies / (options.link * 1e6))
    work_s, busy_s = work(scene, workers, options, options.seed + 1)
    size = sum(brick[3] for brick in scene.bricks)
    per_byte = (job["join_s"] - job["join_start_s"]) / sum(brick[3] for brick in job["bricks"])
    join_s = job["join_start_s"] + per_byte * size + len(scene.bricks) * options.metadata * 1e-3
    join_s = max(join_s, size / (options.link * 1e6))
    return {"bricks": len(scene.bricks), "plan_s": plan_s, "work_s": work_s, "busy_s": busy_s, "join_s": join_s}


def duration(seconds):
    if seconds < 120:
        return f"{seconds:.1f} s"
    return f"{seconds / 60:.0f} min" if seconds < 2 * 3600 else f"{seconds / 3600:.1f} h"


def run(options):
    jobs = [(path, as_measured(json.load(open(path)))) for path in options.jobs]
    print("| job | frames | bricks | workers | plan | work | join | efficiency of work | of all | join of all |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for path, job in jobs:
        for frames in options.frames or [job["frames"]]:
            one = simulate(job, frames, 1, options)
            one_s = one["plan_s"] + one["work_s"] + one["join_s"]
            for workers in options.workers:
                now = simulate(job, frames, workers, options) if workers > 1 else one
                wall_s = now["plan_s"] + now["work_s"] + now["join_s"]
                processors_s = now["plan_s"] + now["busy_s"] + now["join_s"]
                print(f"| {os.path.basename(path)} | {frames} | {now['bricks']} | {workers} | {duration(now['plan_s'])} "
                      f"| {duration(now['work_s'])} | {duration(now['join_s'])} "
                      f"| {one['work_s'] / (workers * now['work_s']):.2f} | {one_s / (workers * wall_s):.2f} "
                      f"| {now['join_s'] / processors_s:.2f} |", flush=True)


def numbers(text):
    return [int(part) for part in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("measure")
    command.add_argument("job")
    command.add_argument("--scanknit", required=True)
    command.set_defaults(call=measure)
    command = commands.add_parser("run")
    command.add_argument("jobs", nargs="+", help="files that `measure` wrote, or JOB/estimate.json")
    command.add_argument("--frames", type=numbers, help="of the whole job; default: as measured")
    command.add_argument("--workers", type=numbers, default=[1, 2, 10, 64, 100, 1000])
    command.add_argument("--bandwidth", type=float, default=2000, help="of the storage, MB/s")
    command.add_argument("--link", type=float, default=1000, help="of a machine, MB/s")
    command.add_argument("--metadata", type=float, default=0.5, help="to open or to make a file, ms")
    command.add_argument("--memory", type=float, default=2900, help="of a worker's volume, MiB: five sevenths of fusion.memory_budget")
    command.add_argument("--spread", type=float, default=0.05, help="of the workers' speed: standard deviation of its logarithm")
    command.add_argument("--slow-share", type=float, default=0.0, help="of the workers: stragglers")
    command.add_argument("--slow-factor", type=float, default=3.0, help="how much longer a straggler takes")
    command.add_argument("--lost", type=float, default=0.0, help="workers that die, of one in an hour")
    command.add_argument("--seed", type=int, default=1)
    command.set_defaults(call=run)
    options = parser.parse_args()
    options.call(options)


if __name__ == "__main__":
    main()
