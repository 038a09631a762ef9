"""Sends the wheels that a robot lacks, a chunk at a time, each verified."""

from __future__ import annotations

import hashlib
import shutil
import tarfile
import tempfile
from pathlib import Path

from ansible import constants as C  # noqa: N812
from ansible.errors import AnsibleActionFail, AnsibleConnectionFailure, AnsibleError
from ansible.plugins.action import ActionBase
from ansible.utils.display import Display

MB = 1_000_000
display = Display()


def chunks(files, limit):
    """Split files into lists of about `limit` bytes; a larger file is one by itself."""
    chunk, size = [], 0
    for entry in files:
        if chunk and size + entry["size"] > limit:
            yield chunk
            chunk, size = [], 0
        chunk.append(entry)
        size += entry["size"]
    if chunk:
        yield chunk


def pack(source, files, archive):
    """Write files into a tar file, each verified while it is read."""
    with tarfile.open(archive, "w", format=tarfile.PAX_FORMAT) as tar:
        for entry in files:
            path = source / entry["name"]
            try:
                with open(path, "rb") as file:
                    found = hashlib.file_digest(file, "sha256").hexdigest()
                    if found != entry["sha256"]:
                        raise AnsibleActionFail(
                            f"{path} is not the file that was verified (sha256 {found} instead of "
                            f"{entry['sha256']}): collect the wheels again"
                        )
                    file.seek(0)
                    member = tarfile.TarInfo(entry["name"])
                    member.size, member.mode = entry["size"], 0o644
                    tar.addfile(member, file)
            except OSError as error:
                raise AnsibleActionFail(
                    f"cannot send {path}: {error.strerror or error}: collect the wheels again"
                ) from None


class ActionModule(ActionBase):
    """The part of qrobot_wheels that runs on the controller."""

    TRANSFERS_FILES = True
    _supports_check_mode = True
    _supports_async = False

    def run(self, tmp=None, task_vars=None):
        """Ask what is missing, and send it."""
        result = super().run(tmp, task_vars)
        del tmp
        _, given = self.validate_argument_spec(
            argument_spec={
                "src": {"type": "path", "required": True},
                "dest": {"type": "path", "default": "/opt/qrobot/wheels"},
                "files": {"type": "list", "elements": "dict", "required": True},
                "chunk_mb": {"type": "int", "default": 48},
            }
        )
        if given["chunk_mb"] < 1:
            raise AnsibleActionFail(f"chunk_mb is {given['chunk_mb']}: give 1 or more")
        host = (task_vars or {}).get("inventory_hostname", "the robot")
        work = None
        try:
            answer = self._ask("missing", given["dest"], task_vars, files=given["files"])
            if answer.get("failed"):
                return answer
            missing = answer["missing"]
            total = sum(entry["size"] for entry in missing)
            result.update(
                changed=bool(missing), files=len(missing), mb=round(total / MB, 1), chunks=0
            )
            if not missing or self._task.check_mode:
                verb = "would be sent" if missing else "to send"
                result["msg"] = f"{len(missing)} of {len(given['files'])} files {verb}"
                result["msg"] += f" ({total / MB:.1f} MB)" if missing else ""
                return result
            parts = list(chunks(missing, given["chunk_mb"] * MB))
            # A chunk lies there twice while it is unpacked.
            need = total + max(sum(entry["size"] for entry in chunk) for chunk in parts)
            if answer["free"] < need:
                raise AnsibleActionFail(
                    f"{answer['free'] // MB} MB are free for {given['dest']} on {host}, but the "
                    f"wheels take {need // MB} MB: make room"
                )
            work = Path(tempfile.mkdtemp(prefix="qrobot-wheels-", dir=C.DEFAULT_LOCAL_TMP))
            sent = 0
            for chunk in parts:
                archive = work / "chunk.tar"
                pack(Path(given["src"]), chunk, archive)
                answer = self._send(archive, chunk, given["dest"], task_vars)
                if answer.get("failed"):
                    # What was sent before stays there: the next run sends the rest.
                    return {**answer, "changed": sent > 0}
                archive.unlink()
                sent += sum(entry["size"] for entry in chunk)
                result["chunks"] += 1
                display.display(f"wheels for {host}: {sent / MB:.0f} of {total / MB:.0f} MB")
            result["msg"] = f"{len(missing)} files sent ({total / MB:.1f} MB)"
            return result
        finally:
            if work is not None:
                shutil.rmtree(work, ignore_errors=True)
            self._remove_tmp_path(self._connection._shell.tmpdir)

    def _ask(self, state, dest, task_vars, **more):
        return self._execute_module(
            module_name="qrobot_wheels",
            module_args={"state": state, "dest": dest, **more},
            task_vars=task_vars,
        )

    def _send(self, archive, chunk, dest, task_vars):
        """Transfer one chunk into the task's folder on the robot, and have it unpacked."""
        if self._connection._shell.tmpdir is None:
            self._make_tmp_path()
        folder = self._connection._shell.tmpdir
        remote = self._connection._shell.join_path(folder, "chunk.tar")
        try:
            self._transfer_file(str(archive), remote)
        except AnsibleConnectionFailure:
            raise  # unreachable, and said so
        except AnsibleError as error:
            reason = " ".join(str(error).split())
            raise AnsibleActionFail(
                f"the robot took no more wheels ({reason}): make room"
            ) from None
        self._fixup_perms2((folder, remote))
        return self._ask("unpacked", dest, task_vars, archive=remote, files=chunk)
