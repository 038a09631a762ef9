"""Amazon Braket without a network: the real SDK on a stubbed client, or on a folder.

Tasks are not made up: the OpenQASM that was submitted is run by Braket's own simulator when the
result is asked for.
"""

from __future__ import annotations

import datetime
import json
from pathlib import Path
from types import SimpleNamespace

import boto3
from botocore.stub import Stubber
from braket.aws import AwsSession

SV1 = "arn:aws:braket:::device/quantum-simulator/amazon/sv1"
GARNET = "arn:aws:braket:eu-north-1::device/qpu/iqm/Garnet"
ACCOUNT = "arn:aws:braket:us-east-1:123456789012:quantum-task"
DONE = ("COMPLETED",) * 3
"""Of a script: asked by our poll, by our fetch, and by the SDK's result()."""

KEY = "AKIAPL4NTED012345678"
SECRET = "pl4ntedAwsSecretKeyValue0123456789abcdef"
BEGUN = datetime.datetime(2026, 11, 1, 12, 0, 0, tzinfo=datetime.UTC)


def capabilities(
    qubits=34, cost=(0.075, "minute"), gates=("zz", "cz", "h", "ry", "rz", "rx"), shots=100_000
):
    """Return what a device tells of itself, as Braket's schema has it."""
    schema = "braket.device_schema."
    about = {
        "braketSchemaHeader": {
            "name": f"{schema}simulators.gate_model_simulator_device_capabilities",
            "version": "1",
        },
        "service": {
            "braketSchemaHeader": {"name": f"{schema}device_service_properties", "version": "1"},
            "executionWindows": [
                {
                    "executionDay": "Everyday",
                    "windowStartHour": "00:00:00",
                    "windowEndHour": "23:59:59",
                }
            ],
            "shotsRange": [0, shots],
        },
        "action": {
            "braket.ir.openqasm.program": {
                "actionType": "braket.ir.openqasm.program",
                "version": ["1"],
                "supportedOperations": list(gates),
                "supportedResultTypes": [
                    {
                        "name": kind,
                        "observables": ["x", "y", "z", "h", "i"],
                        "minShots": 1,
                        "maxShots": shots,
                    }
                    for kind in ("Sample", "Expectation", "Variance")
                ],
            }
        },
        "paradigm": {
            "braketSchemaHeader": {
                "name": f"{schema}simulators.gate_model_simulator_paradigm_properties",
                "version": "1",
            },
            "qubitCount": qubits,
        },
        "deviceParameters": {},
    }
    if cost is not None:
        about["service"]["deviceCost"] = {"price": cost[0], "unit": cost[1]}
    return json.dumps(about)


def device(arn=SV1, status="ONLINE", **about):
    """Return an answer to get_device."""
    return {
        "deviceArn": arn,
        "deviceCapabilities": capabilities(**about),
        "deviceName": arn.rsplit("/", 1)[-1],
        "deviceStatus": status,
        "deviceType": "QPU" if "/qpu/" in arn else "SIMULATOR",
        "providerName": "somebody",
    }


def task(number, state, arn=SV1, shots=20, why=""):
    """Return an answer to get_quantum_task."""
    answer = {
        "createdAt": BEGUN, "deviceArn": arn, "deviceParameters": "{}", "shots": shots,
        "outputS3Bucket": "amazon-braket-x", "outputS3Directory": f"tasks/{number}",
        "quantumTaskArn": f"{ACCOUNT}/{name(number)}", "status": state,
        "actionMetadata": {"actionType": "braket.ir.openqasm.program", "executableCount": 1,
                           "programCount": 1},
    }  # fmt: skip
    if state == "COMPLETED":
        answer["endedAt"] = BEGUN + datetime.timedelta(seconds=4)
    if why:
        answer["failureReason"] = why
    return answer


def on(session, device=None, **more):
    return {"device": device or SV1, "device_options": {"aws_session": session}, **more}


def name(number):
    return f"11111111-2222-3333-4444-{number:012d}"


def run(request):
    """Return the text that Braket would put into the bucket."""
    from braket.default_simulator import StateVectorSimulator
    from braket.ir.openqasm import Program
    from braket.tasks import GateModelQuantumTaskResult

    program = Program.parse_raw(request["action"])
    found = StateVectorSimulator().run(program, shots=request["shots"])
    text = json.loads(found.json())
    # The simulator names what was asked for, and the service tells its values too.
    text["resultTypes"] = [
        {"type": json.loads(one.type.json()), "value": one.value.tolist()}
        for one in GateModelQuantumTaskResult.from_object(found).result_types
    ]
    return json.dumps(text)


class Session(AwsSession):
    """An ``AwsSession`` with planted keys and a client that a Stubber answers for.

    Parameters
    ----------
    script
        Answers in sequence: ``("device", {...})``, ``("create",)``, a state of the task that was
        created last, or ``("error", operation, code, message, status)``.
    """

    def __init__(self, *script, arn=SV1, region="us-east-1"):
        boto = boto3.Session(
            aws_access_key_id=KEY, aws_secret_access_key=SECRET, region_name=region
        )
        client = boto.client("braket")
        super().__init__(boto_session=boto, braket_client=client, default_bucket="amazon-braket-x")
        self.sent = []
        client.meta.events.register(
            "before-parameter-build.braket.CreateQuantumTask",
            lambda params, **_: self.sent.append(dict(params)),
        )
        self.stub = Stubber(client)
        number = 0
        for step in script:
            kind, *rest = (step,) if isinstance(step, str) else step
            if kind == "device":
                self.stub.add_response("get_device", device(arn, **(rest[0] if rest else {})))
            elif kind == "create":
                number += 1
                answer = {"quantumTaskArn": f"{ACCOUNT}/{name(number)}"}
                self.stub.add_response("create_quantum_task", answer)
            elif kind == "error":
                operation, code, message, status = rest
                self.stub.add_client_error(operation, code, message, status)
            else:
                answer = task(number, kind, arn, why=rest[0] if rest else "")
                self.stub.add_response("get_quantum_task", answer)
        self.stub.activate()

    def add_braket_user_agent(self, user_agent):
        """Keep the client: the SDK would make another one, which has no stub."""

    def retrieve_s3_object_body(self, s3_bucket, s3_object_key):
        return run(self.sent[int(s3_object_key.split("/")[1]) - 1])


class FolderSession(AwsSession):
    """An ``AwsSession`` whose service is a folder: it outlives the process that submits."""

    def __init__(self, folder):
        boto = boto3.Session(
            aws_access_key_id=KEY, aws_secret_access_key=SECRET, region_name="us-east-1"
        )
        super().__init__(boto_session=boto, default_bucket="amazon-braket-x")
        self.folder = Path(folder)
        self.folder.mkdir(exist_ok=True)
        self.state = "COMPLETED"
        self.cancelled = []
        self.braket_client = SimpleNamespace(search_quantum_tasks=self.search)
        self.after_create = self.before_get = lambda: None

    def get_device(self, arn):
        return device(arn)

    def create_quantum_task(self, **request):
        number = len(list(self.folder.iterdir())) + 1
        (self.folder / f"{number}.json").write_text(json.dumps(request))
        self.after_create()
        return f"{ACCOUNT}/{name(number)}"

    def get_quantum_task(self, arn):
        self.before_get()
        return task(int(arn.rsplit("-", 1)[-1]), self.state)

    def cancel_quantum_task(self, arn):
        self.cancelled.append(arn)

    def search(self, filters, nextToken="1"):
        """Return one task a page, as a service with many would."""
        wanted = {one["name"]: one["values"] for one in filters}
        number = int(nextToken)
        path = self.folder / f"{number}.json"
        if not path.exists():
            return {"quantumTasks": []}
        request = json.loads(path.read_text())
        found = [
            {"quantumTaskArn": f"{ACCOUNT}/{name(number)}", "tags": request["tags"]}
            for arn in wanted["deviceArn"]
            if request["deviceArn"] == arn
        ]
        return {"quantumTasks": found, "nextToken": str(number + 1)}

    def retrieve_s3_object_body(self, s3_bucket, s3_object_key):
        return run(json.loads((self.folder / f"{s3_object_key.split('/')[1]}.json").read_text()))
