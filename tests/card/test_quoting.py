"""Whatever a value holds: what is written parses back to it."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import pytest
from card.made import HOSTILE, name_of_keyfile
from hypothesis import given
from hypothesis import strategies as st

from qrobot.card.quoting import keyfile_ssid, keyfile_text, netplan_ssid, quoted, yaml_text

yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")

TEXTS = st.text(st.characters(exclude_categories=["Cs"])) | st.sampled_from(HOSTILE)
KEYS = TEXTS.filter(lambda key: len(key) <= 80)  # YAML's limit for a key is 1024 with escapes
VALUES: Any = st.recursive(
    TEXTS | st.booleans() | st.integers(),
    lambda inner: st.lists(inner) | st.dictionaries(KEYS, inner),
    max_leaves=6,
)


@given(
    st.dictionaries(KEYS | st.sampled_from(["yes", "on", "n", "null", "1e3", "=", "<<"]), VALUES)
)
def test_yaml_parses_back(value: dict[str, Any]) -> None:
    text = yaml_text(value)
    assert text.isascii()
    assert (yaml.safe_load(text) or {}) == value


@given(TEXTS)
def test_quotes_are_toml_too(text: str) -> None:
    assert tomllib.loads(f"value = {quoted(text)}") == {"value": text}


@given(TEXTS.filter(bool))
def test_a_keyfile_holds_the_name(ssid: str) -> None:
    written = keyfile_ssid(ssid)
    assert name_of_keyfile(written) == ssid.encode()
    assert written.isascii()
    assert not written.startswith("-"), "would be an option of imager_custom"
    assert written.strip() == written
    assert "\n" not in written


@pytest.mark.parametrize("ssid", ["Warehouse", "Warehouse 2.4-a_b"])
def test_plain_names_stay_readable(ssid: str) -> None:
    assert keyfile_ssid(ssid) == netplan_ssid(ssid) == ssid


@given(TEXTS.filter(bool))
def test_netplan_gets_nothing_that_it_would_escape(ssid: str) -> None:
    written = netplan_ssid(ssid)
    assert not set(written) & set('"\\\n\t\x7f')
    assert name_of_keyfile(written) == ssid.encode()


@given(st.text(st.sampled_from([*" \\\\sntr;#='a", "é"])))
def test_a_keyfile_holds_a_text(text: str) -> None:
    """Read back by GLib's rules: blanks at the front are skipped, a backslash escapes."""
    written = keyfile_text(text)
    assert written.strip() == written
    meaning = {"s": " ", "n": "\n", "t": "\t", "r": "\r", "\\": "\\"}
    assert re.sub(r"\\(.)", lambda found: meaning[found[1]], written) == text
