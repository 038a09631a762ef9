"""Names, capabilities, missing extras and plugins by entry point."""

from __future__ import annotations

import importlib.metadata

import pytest

import qrobot
from qrobot.backends import Capabilities, Planner, Search, Stop, available, get, names, registry


class OneByOne:
    """The planner of docs/extending.md: every order on a trip of its own."""

    name = "one-by-one"
    capabilities = Capabilities(kind="planner")

    def search(self, instance, *, stop, seed=0, start=None, on_best=None):
        routes = [list(nodes) for nodes in instance.order_nodes]
        enough = len(routes) <= len(instance.vehicle_capacities)
        return Search(routes=routes if enough else None)


@pytest.fixture
def plugin(monkeypatch: pytest.MonkeyPatch) -> None:
    assert qrobot.solve  # pydantic, which it imports, asks for entry points of its own
    entry = importlib.metadata.EntryPoint("one-by-one", f"{__name__}:OneByOne", registry.GROUP)
    monkeypatch.setattr(importlib.metadata.EntryPoint, "load", lambda _: OneByOne)
    monkeypatch.setattr(
        importlib.metadata, "entry_points", lambda **_: importlib.metadata.EntryPoints([entry])
    )


@pytest.mark.usefixtures("plugin")
def test_a_plugin_is_a_backend_like_any_other() -> None:
    from oracles import paper_shaped

    assert "one-by-one" in names()
    assert available("one-by-one")
    assert registry.capabilities("one-by-one").kind == "planner"
    instance = paper_shaped(4, 2, 0).with_robots(None)
    result = qrobot.solve(instance, backend="one-by-one", deadline=5)
    assert result.steps == ("one-by-one",)
    assert len(result.plan.trips) == 4
    assert qrobot.check(result.plan, instance).ok


def test_every_planner_of_ours_keeps_the_protocol() -> None:
    for name in names():
        if not available(name):
            continue
        backend = get(name)
        assert backend.name == name
        assert backend.capabilities.kind == (
            "planner" if isinstance(backend, Planner) else "sampler"
        )


def test_unknown_names_are_told_what_there_is() -> None:
    assert not available("nonsense")
    with pytest.raises(qrobot.InputError, match="use one of: auto, exact, pyvrp"):
        get("nonsense")


def test_a_missing_extra_names_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "is_installed", lambda module: module != "pyvrp")
    with pytest.raises(qrobot.MissingExtraError, match=r"pip install 'qrobot\[planners\]'"):
        get("pyvrp")


def test_stops_nest_and_count() -> None:
    outer = Stop(max_work=10)
    inner = outer.within(max_work=3)
    assert not inner(2)
    assert inner(3)
    assert not outer(3)
    outer.request()
    assert inner()
    assert inner.remaining == 0.0
    assert Stop(seconds=0.0)()
    assert Stop().remaining == float("inf")
