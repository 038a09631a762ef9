"""What the roles have on a robot, from the file C(vars/owns.yml) of each role."""

from __future__ import annotations

DOCUMENTATION = r"""
name: qrobot_owns
short_description: What the roles have on a robot
description:
  - Reads C(vars/owns.yml) of every role; docs/provisioning.md tells what stands in it.
  - Templates in it are evaluated for the robot, and only those of the keys asked for.
options:
  _terms:
    description: Keys such as V(files); the answer is one list of what all roles have there.
    required: true
    type: list
    elements: str
  where:
    description: >-
      A key that names a setting, V(switch) or V(reset); roles whose setting is false are left out.
    type: str
  by_role:
    description: The answer is one dictionary, from the name of a role to what it has.
    type: bool
    default: false
author: The qRobot authors
"""

EXAMPLES = r"""
- name: Install what the roles that are switched on need
  ansible.builtin.apt:
    name: "{{ query('qrobot_owns', 'packages', where='switch') }}"
"""

RETURN = r"""
_list:
  description: What the roles have, the roles by their names; with O(by_role) one dictionary.
  type: list
  elements: raw
"""

from functools import cache
from pathlib import Path

from ansible.parsing.dataloader import DataLoader
from ansible.plugins.lookup import LookupBase
from ansible.template import trust_as_template

ROLES = Path(__file__).resolve().parents[2] / "roles"


class LookupModule(LookupBase):
    def run(self, terms, variables=None, **kwargs):
        self.set_options(var_options=variables, direct=kwargs)
        where = self.get_option("where")
        roles, found = read(), {}
        for name, owns in roles.items():
            if where not in owns or self._is_on(owns[where]):
                found[name] = [entry for key in terms for entry in self._entries(roles, name, key)]
        if self.get_option("by_role"):
            return [found]
        return [entry for entries in found.values() for entry in entries]

    def _is_on(self, setting):
        return self._templar.evaluate_conditional(trust_as_template(f"{setting} | bool"))

    def _entries(self, roles, name, key):
        """Return what a role has there: a list, the keys of a dictionary, or one text."""
        if key == "selected_by":
            return selected_by(roles, name)
        value = self._templar.template(roles[name].get(key, []))
        return [value] if isinstance(value, str) else list(value)


@cache
def read():
    """Return what each role owns, its templates unread."""
    found = {}
    for path in sorted(ROLES.glob("*/vars/owns.yml")):
        name = path.parts[-3]
        variables = DataLoader().load_from_file(str(path), trusted_as_template=True)
        found[name] = variables[f"{name}_owns"]
    return found


def selected_by(roles, name):
    """Return the tags that select a role: its own, and those of the roles that need it."""
    owns = roles[name]
    tags = {*owns["tags"], *(tag for step in owns.get("steps", []) for tag in step["tags"])}
    for other, needing in roles.items():
        if name in needing.get("needs", []):
            tags.update(selected_by(roles, other))
    return sorted(tags)
