"""A thousand nodes at 10^12 rows, simulated: what the store, the scheduler and failures cost.

    python tools/cluster_plan.py              # the table of docs/cluster.md

Every process takes a partition, works, hands the part to its node's link, which sends one part
after the other, then puts two objects (the part's pieces and the record) into a store that takes
so many requests a second. Nodes fail at random moments: what their processes had underway is
lost, and the batch system starts the same shard again a minute later. With a scheduler, every
task costs it some time before it begins, one after the other.
"""

from __future__ import annotations

import heapq
import random
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Plan:
    """What a run is made of; the defaults are measured, or what such machines have."""

    partitions: int = 1_000_000
    rows: int = 1_000_000
    nodes: int = 1_000
    processes: int = 32
    work_us: float = 3.4
    """CPU of a row, read, solved and written."""
    out_bytes: float = 85.0
    in_bytes: float = 0.0
    """Of a row; 0 where rows are made of a formula."""
    link_gb_s: float = 1.0
    """Of a node."""
    store_gb_s: float = 50.0
    """Of the store, for all nodes."""
    requests_s: float = 100_000.0
    """That the store takes, over all prefixes."""
    piece_mb: float = 8.0
    failures_h: float = 1.0
    """Nodes that are lost in an hour."""
    restart_s: float = 60.0
    task_ms: float = 0.0
    """Of a scheduler for each task; 0 for shards, which have none."""
    tasks: int = 0


@dataclass(frozen=True)
class Outcome:
    """Seconds until the last record, and what was done twice."""

    seconds: float
    redone: int
    scheduler_s: float


def lower_bound(plan: Plan) -> float:
    """Return the seconds that the slowest resource needs for its work alone."""
    rows = plan.partitions * plan.rows
    work = rows * plan.work_us * 1e-6 / (plan.nodes * plan.processes)
    send = rows * (plan.out_bytes + plan.in_bytes) / (1e9 * _rate_gb_s(plan) * plan.nodes)
    asked = plan.partitions * _requests(plan) / plan.requests_s
    return max(work, send, asked, plan.tasks * plan.task_ms * 1e-3)


def _rate_gb_s(plan: Plan) -> float:
    return min(plan.link_gb_s, plan.store_gb_s / plan.nodes)


def _requests(plan: Plan) -> float:
    """Return requests a partition: its record is looked for, pieces, completion, its record."""
    return 3.0 + plan.rows * plan.out_bytes / 1e6 / plan.piece_mb


def simulate(plan: Plan, seed: int = 0) -> Outcome:
    """Run a plan to its end."""
    chance = random.Random(seed)
    work_s = plan.rows * plan.work_us * 1e-6
    send_s = plan.rows * (plan.out_bytes + plan.in_bytes) / (1e9 * _rate_gb_s(plan))
    request_s = _requests(plan) / plan.requests_s
    left = [len(range(k, plan.partitions, plan.nodes)) for k in range(plan.nodes)]
    link = [0.0] * plan.nodes
    fails = [
        chance.expovariate(plan.failures_h / 3600.0 / plan.nodes) if plan.failures_h else 1e99
        for _ in range(plan.nodes)
    ]
    share = plan.partitions / plan.tasks if plan.tasks else 1.0
    store = scheduler = end = 0.0
    redone = 0
    begun: list[tuple[float, int, int]] = [
        (0.0, node, process) for process in range(plan.processes) for node in range(plan.nodes)
    ]
    heapq.heapify(begun)
    while begun:
        at, node, process = heapq.heappop(begun)
        if not left[node]:
            continue
        left[node] -= 1
        if plan.tasks:
            scheduler = max(scheduler, at) + plan.task_ms * 1e-3 / share
            at = scheduler
        # Work takes a bit more or less, so that processes do not send all at the same moment.
        done = at + work_s * chance.uniform(0.9, 1.1)
        link[node] = max(link[node], done) + send_s
        store = max(store + request_s, link[node] - 1.0)
        there = max(link[node], store)
        if at <= fails[node] < there:
            left[node] += 1
            redone += 1
            again = fails[node] + plan.restart_s
            link[node] = min(link[node], again)
            heapq.heappush(begun, (again, node, process))
            continue
        end = max(end, there)
        heapq.heappush(begun, (there, node, process))
    return Outcome(end, redone, scheduler)


PLAN = Plan()
PLANS = {
    "shards, rows of a formula": PLAN,
    "the same, input read from the store (56 B a row)": replace(PLAN, in_bytes=56.0),
    "the same, a store of 200 GB/s": replace(PLAN, store_gb_s=200.0),
    "the same, ten nodes lost an hour": replace(PLAN, failures_h=10.0),
    "a store of one prefix (3,500 requests/s)": replace(PLAN, requests_s=3_500.0),
    "Dask, a task a partition": replace(PLAN, task_ms=2.0, tasks=PLAN.partitions),
    "Dask, 10,000 tasks of 100 partitions": replace(PLAN, task_ms=2.0, tasks=10_000),
}


def scaled(plan: Plan, factor: int) -> Plan:
    """Return a plan with so many times fewer nodes and partitions, and a store to match."""
    return replace(
        plan,
        partitions=plan.partitions // factor,
        nodes=plan.nodes // factor,
        store_gb_s=plan.store_gb_s / factor,
        requests_s=plan.requests_s / factor,
        failures_h=plan.failures_h / factor,
        tasks=plan.tasks // factor,
        task_ms=plan.task_ms * factor,
    )


def table() -> str:
    """Return the table of the plans, in Markdown."""
    lines = [
        "| plan | lower bound min | simulated min | partitions done twice |",
        "|---|---:|---:|---:|",
    ]
    for name, plan in PLANS.items():
        found = simulate(plan)
        lines.append(
            f"| {name} | {lower_bound(plan) / 60:.0f} | {found.seconds / 60:.0f} | {found.redone} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
