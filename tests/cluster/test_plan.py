"""The plan for 10^12 rows: the page says what the simulation of scheduler and store finds."""

from dataclasses import replace
from pathlib import Path

import pytest

import cluster_plan as plans


def test_the_page_holds_the_simulated_table(repo_root: Path) -> None:
    page = (repo_root / "docs" / "cluster.md").read_text("utf-8")
    table = page.split("<!-- the table of the plans -->\n")[1].split("\n\n")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[2:]]
    assert [row[0] for row in rows] == list(plans.PLANS)
    for name, bound, simulated, _ in rows:
        plan = plans.PLANS[name]
        assert round(plans.lower_bound(plan) / 60) == int(bound)
        # A hundredth of the machine, with a store to match, takes as long.
        small = plans.simulate(plans.scaled(plan, 100)).seconds / 60
        assert small == pytest.approx(int(simulated), rel=0.1, abs=1.0), name


def test_the_simulation_agrees_with_what_can_be_calculated() -> None:
    plan = plans.scaled(plans.PLAN, 100)
    fast = replace(plan, store_gb_s=1e6, link_gb_s=1e6, requests_s=1e9, failures_h=0.0)
    found = plans.simulate(fast)
    assert found.redone == 0
    assert found.seconds == pytest.approx(plans.lower_bound(fast), rel=0.1)
    slow_store = replace(fast, store_gb_s=0.5)
    assert plans.simulate(slow_store).seconds == pytest.approx(1e10 * 85 / 0.5e9, rel=0.05)
    few_requests = replace(fast, requests_s=35.0)
    assert plans.simulate(few_requests).seconds == pytest.approx(
        plans.lower_bound(few_requests), rel=0.05
    )
    asked = replace(fast, tasks=fast.partitions, task_ms=200.0)
    assert plans.simulate(asked).scheduler_s == pytest.approx(2_000.0, rel=0.05)


def test_lost_nodes_cost_what_was_underway_and_no_more() -> None:
    plan = replace(plans.scaled(plans.PLAN, 100), failures_h=20.0)
    found = plans.simulate(plan)
    calm = plans.simulate(replace(plan, failures_h=0.0))
    assert 0 < found.redone <= plan.nodes * plan.processes
    assert calm.seconds < found.seconds < calm.seconds + 60 + 2 * plan.restart_s + 400
