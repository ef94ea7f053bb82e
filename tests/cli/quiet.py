"""quiet.py COMMAND... - runs a test of the clock, and tells a fault from a busy machine.

Exit 0 where the command ends with 0. Where it fails, the exit code says whose fault it is: 77,
which meson counts as skipped, after a line `inconclusive: WHY`, where the machine was busy before,
during or after; the command's own code where it was quiet. Busy is: a loop of the same length got
less than nine tenths of a core, took a tenth more processor time on one side of the test than on
the other, other processes (the hypervisor among them) took more than an eighth of the cores that
this one may use while the test ran, or a sleep beside the test ended 0.3 s late, as
where a virtual machine stands still: nobody's processor time tells that of processes that sleep.
"""

import os
import subprocess
import sys
import threading
import time
from typing import NamedTuple

INCONCLUSIVE = 77
SHARE, DRIFT, OTHERS = 0.9, 1.1, 1 / 8
LOOPS, ROUNDS = 8, 200_000  # about 10 ms each
NAP_S, LATE_S = 0.05, 0.3


class Canary(NamedTuple):
    """What a loop of fixed length met: processor time over wall time, and its processor time."""

    share: float
    cpu_s: float


def canary() -> Canary:
    """Runs the loop a few times: the median of the shares, the least processor time."""
    shares, least = [], float("inf")
    for _ in range(LOOPS):
        wall, cpu = time.perf_counter(), time.process_time()
        total = 0
        for i in range(ROUNDS):
            total += i
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        shares.append(min(1.0, cpu / wall))
        least = min(least, cpu)
    return Canary(sorted(shares)[LOOPS // 2], least)


def busy_s() -> float:
    """Processor time [s] that was used, or stolen, on the cores that this process may use."""
    cores = {f"cpu{i}" for i in os.sched_getaffinity(0)}
    total = 0
    with open("/proc/stat", encoding="ascii") as f:
        for line in f:
            name, *ticks = line.split()
            if name in cores:
                user, nice, system, _, _, irq, softirq, steal = map(int, ticks[:8])
                total += user + nice + system + irq + softirq + steal
    return total / os.sysconf("SC_CLK_TCK")


def own_s() -> float:
    """Processor time [s] of this process and of those that it has waited for."""
    return sum(os.times()[:4])


class Sleeper(threading.Thread):
    """Sleeps again and again until end(), and tells by how much the latest sleep was late."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.late_s = 0.0
        self.over = threading.Event()

    def run(self) -> None:
        over = False
        while not over:
            until = time.monotonic() + NAP_S
            over = self.over.wait(NAP_S)
            self.late_s = max(self.late_s, time.monotonic() - until)

    def end(self) -> float:
        self.over.set()
        self.join()
        return self.late_s


def why_busy(before: Canary, after: Canary, others: float, late_s: float = 0.0) -> str:
    """The sign of a busy machine; empty where there is none. others: cores taken, as a share."""
    least = min(before.share, after.share)
    if least < SHARE:
        return f"a loop beside the test got {100 * least:.0f} % of a core"
    drift = max(before.cpu_s, after.cpu_s) / min(before.cpu_s, after.cpu_s)
    if drift > DRIFT:
        return f"a core was {drift:.2f} times as fast on one side of the test as on the other"
    if others > OTHERS:
        return f"others took {100 * others:.0f} % of the cores while the test ran"
    if late_s > LATE_S:
        return f"the machine stood still for {late_s:.2f} s while the test ran"
    return ""


def main(command: list[str]) -> int:
    busy, own, wall = busy_s(), own_s(), time.perf_counter()
    before = canary()
    sleeper = Sleeper()
    sleeper.start()
    code = subprocess.run(command, check=False).returncode
    late_s = sleeper.end()
    after = canary()
    wall = (time.perf_counter() - wall) * len(os.sched_getaffinity(0))
    others = max(0.0, busy_s() - busy - (own_s() - own)) / wall
    why = why_busy(before, after, others, late_s)
    print(
        f"# quiet: {100 * before.share:.0f} and {100 * after.share:.0f} % of a core, loops of"
        f" {1e3 * before.cpu_s:.1f} and {1e3 * after.cpu_s:.1f} ms, others {100 * others:.0f} %,"
        f" sleeps late by {1e3 * late_s:.0f} ms"
    )
    if code == 0 or not why:
        return code if code >= 0 else 128 - code
    print(f"inconclusive: {why}", flush=True)
    return INCONCLUSIVE


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
