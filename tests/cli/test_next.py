"""``qrobot next``: a table, JSON, exit codes."""

from __future__ import annotations

import json

from cli.test_commands import EXAMPLES, one_sentence, qrobot

QUESTION = EXAMPLES / "paper-7-items.json"


def test_the_terminal_gets_the_next_order_and_a_table() -> None:
    done = qrobot("next", QUESTION)
    data = json.loads(qrobot("next", QUESTION, "--json").stdout)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0] == f"next: {data['orders'][0]['order']}"
    assert lines[2].split() == ["order", "extra", "distance", "distance", "seconds", "load"]
    assert [line.split()[0] for line in lines[4:]] == [one["order"] for one in data["orders"]]


def test_json_is_all_that_is_printed() -> None:
    question = EXAMPLES / "small-warehouse.json"
    here = qrobot("next", question, "--at", "8,10,1", "--robot", "R2", "--json")
    data = json.loads(here.stdout)
    assert data["schema"] == "qrobot.next/1"
    assert (data["at"], data["robot"], len(data["orders"])) == ("8,10,1", "R2", 24)
    best = data["orders"][0]
    assert best["extra"] == 0.0  # it lies here
    assert set(best) == {
        "order", "extra", "distance", "seconds", "load", "items", "is_shortest",
    }  # fmt: skip


def test_what_is_too_heavy_is_left_out_and_said() -> None:
    done = qrobot("next", QUESTION, "--capacity", "4")
    assert done.stdout.endswith("left out: 2 orders too heavy for the robot\n")
    none = qrobot("next", QUESTION, "--capacity", "0.5")
    assert none.returncode == 1
    assert "every order is heavier than 0.5" in one_sentence(none)


def test_a_place_that_does_not_exist_is_one_sentence() -> None:
    done = qrobot("next", QUESTION, "--at", "nowhere")
    assert done.returncode == 2
    assert "at: 'nowhere' is not a place here; give depot" in one_sentence(done)
