"""Where a process runs and how fast the CPU goes meanwhile: pinned, bound to a node where the
system permits, followed where it tells."""

import csv
import os
import pathlib
import subprocess
import time

from support import FAULTY, Skip, campaign, diagonal, rows, run, tap

TEXT = """
name: machine
limits: {time: 20s}
sampling: {processes: 1, samples: 3, max_samples: 3, inner: 0.0001s}
parts:
  - name: a
    problems: ["%s"]
    solvers: ['faulty_steady:seconds=%s']
"""
MPOL_DEFAULT, MPOL_BIND, SET_MEMPOLICY = 0, 2, 238  # x86-64


def binding_permitted():
    """Asked of the system in a process of its own."""
    code = f"""
import ctypes, sys
c = ctypes.CDLL(None, use_errno=True)
sys.exit(c.syscall({SET_MEMPOLICY}, {MPOL_BIND}, ctypes.byref(ctypes.c_ulong(1)), 64) != 0)"""
    return (
        os.uname().machine == "x86_64" and subprocess.run(["python3", "-c", code]).returncode == 0
    )


def children(pid):
    return [int(p) for p in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def memory_is_bound_where_it_can_be(d):
    """Column mem_node tells the node, and the pages of the process are bound to it; unpinned
    processes are not bound."""
    c = campaign(d, TEXT % (diagonal(d, 4), 0.3))
    p = subprocess.Popen(
        [FAULTY, "run", str(c), "--out", str(d / "o"), "--quiet"],
        stdout=subprocess.DEVNULL,
        env=dict(os.environ, OPENBLAS_NUM_THREADS="1"),
    )
    seen = ""
    give_up = time.time() + 30
    while p.poll() is None and time.time() < give_up and "bind" not in seen:
        for child in children(p.pid):
            try:
                seen = pathlib.Path(f"/proc/{child}/numa_maps").read_text()
            except OSError:
                pass
        time.sleep(0.02)
    assert p.wait(60) == 0
    nodes = {r["mem_node"] for r in rows(d / "o")}
    run("run", c, "--out", d / "free", "--quiet", "--no-pin", exe=FAULTY)
    assert {(r["mem_node"], r["cpu_set"]) for r in rows(d / "free")} == {("", "")}
    if not binding_permitted():
        assert nodes == {""}, nodes
        raise Skip("the system does not permit binding; the column is empty")
    assert len(nodes) == 1 and "" not in nodes, nodes
    assert not pathlib.Path("/proc/self/numa_maps").exists() or f" bind:{nodes.pop()} " in seen, (
        seen[:300]
    )


def frequency_is_read_during_the_run(d):
    """In every row and beside every canary; empty where the machine does not tell."""
    run("run", campaign(d, TEXT % (diagonal(d, 4), 0.002)), "--out", d / "o", "--quiet", exe=FAULTY)
    tells = pathlib.Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_cur_freq").exists()
    with (d / "o/canary.csv").open(newline="") as f:
        canaries = list(csv.DictReader(f))
    got = [r["freq_MHz"] for r in rows(d / "o")] + [r["freq_MHz"] for r in canaries]
    assert len(canaries) == 2 and all((float(x) > 100) if tells else x == "" for x in got), got
    # canaries of another version make room
    (d / "o/canary.csv").write_text("utc,host,canary_s,load1\nthen,there,1,1\n")
    run("run", campaign(d, TEXT % (diagonal(d, 4), 0.002)), "--out", d / "o", "--quiet", exe=FAULTY)
    assert (
        "then,there" in (d / "o/canary.old.csv").read_text()
        and "then" not in (d / "o/canary.csv").read_text()
    )


tap([memory_is_bound_where_it_can_be, frequency_is_read_during_the_run])
