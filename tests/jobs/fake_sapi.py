"""D-Wave's solver API on the loopback: enough of it for the real SDK to run against.

A QPU (structured solver) and a hybrid BQM solver. Every accepted problem is answered by
steepest descent. `refuse` makes it answer 401, `hold` keeps problems pending.
"""

from __future__ import annotations

import base64
import hashlib
import io
import itertools
import json
import struct
import sys
import threading
import time
import traceback
import zlib
from contextlib import contextmanager
from datetime import UTC, datetime
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import SimpleNamespace
from uuid import uuid4

import dimod
from dwave.samplers import SteepestDescentSampler
from jobs.fake_solvers import solvers


def now():
    return datetime.now(UTC).isoformat().replace("+00:00", "Z")


def doubles(values):
    return base64.b64encode(struct.pack(f"<{len(values)}d", *values)).decode()


def ints(values):
    return base64.b64encode(struct.pack(f"<{len(values)}i", *values)).decode()


class Sapi:
    def __init__(self):
        self.solvers = solvers()
        self.problems = {}
        self.uploads = {}
        self.answers = {}
        self.errors = []
        self.url = ""
        self.tokens = []
        self.posted = 0
        self.refuse = False
        self.hold = False
        self.deaf = False
        self.solve_seconds = 0.02

    def answer_qpu(self, job):
        qubits = self.solvers[0]["properties"]["qubits"]
        couplers = self.solvers[0]["properties"]["couplers"]
        lin = base64.b64decode(job["data"]["lin"])
        lin = struct.unpack(f"<{len(lin) // 8}d", lin)
        linear = {q: b for q, b in zip(qubits, lin, strict=True) if b == b}
        quad = base64.b64decode(job["data"]["quad"])
        quad = list(struct.unpack(f"<{len(quad) // 8}d", quad))
        edges = [(u, v) for u, v in couplers if u in linear and v in linear]
        vartype = "SPIN" if job["type"] == "ising" else "BINARY"
        bqm = dimod.BQM(linear, dict(zip(edges, quad, strict=True)), 0.0, vartype)
        reads = job["params"].get("num_reads", 1)
        found = SteepestDescentSampler().sample(bqm, num_reads=reads, seed=1).aggregate()
        active = sorted(linear)
        column = [list(found.variables).index(q) for q in active]
        packed = b""
        for row in found.record.sample:
            bits = [int(row[c] > 0) for c in column]
            bits += [0] * (-len(bits) % 8)
            packed += bytes(
                sum(bit << (7 - i) for i, bit in enumerate(bits[k : k + 8]))
                for k in range(0, len(bits), 8)
            )
        return {
            "format": "qp",
            "active_variables": ints(active),
            "energies": doubles([float(e) for e in found.record.energy]),
            "solutions": base64.b64encode(packed).decode(),
            "num_occurrences": ints([int(n) for n in found.record.num_occurrences]),
            "num_variables": self.solvers[0]["properties"]["num_qubits"],
            "timing": {"qpu_access_time": 15000.0, "qpu_sampling_time": 900.0},
        }

    def answer_nonlinear(self, number, job):
        from dwave.optimization import Model

        model = Model.from_file(io.BytesIO(self.uploads[job["data"]["data"]]))
        if not model.is_locked():
            model.lock()
        (x,) = model.iter_decisions()
        model.states.resize(2)
        best = []
        for bits in itertools.product((0, 1), repeat=x.size()):
            x.set_state(0, bits)
            best.append((float(model.objective.state(0)), bits))
        best.sort()
        for k in range(2):
            x.set_state(k, best[k][1])
        with model.states.to_file() as file:
            self.answers[number] = file.read()
        return {
            "format": "binary-ref", "auth_method": "sapi-token",
            "url": f"{self.url}answers/{number}", "shape": {},
            "timing": {"run_time": 5_000_000, "charge_time": 5_000_000, "warnings": []},
        }  # fmt: skip

    def answer_hybrid(self, job):
        if job["type"] == "cqm":
            cqm = dimod.CQM.from_file(self.uploads[job["data"]["data"]])
            found = dimod.ExactCQMSolver().sample_cqm(cqm).truncate(3)
            found.info.update(run_time=5_000_000, charge_time=5_000_000)
            return {"format": "bq", "data": found.to_serializable()}
        bqm = dimod.BQM.from_file(self.uploads[job["data"]["data"]])
        found = SteepestDescentSampler().sample(bqm, num_reads=1, seed=1)
        found.info.update(run_time=3_000_000, charge_time=3_000_000)
        return {"format": "bq", "data": found.to_serializable()}

    def message(self, number, with_answer=False):
        job = self.problems[number]
        late = time.time() - job["begun"] > self.solve_seconds
        if job["status"] == "PENDING" and late and not self.hold:
            job["status"], job["solved_on"] = "COMPLETED", now()
        message = {
            "id": number,
            "status": job["status"],
            "type": job["type"],
            "label": job.get("label"),
            "solver": job["solver"],
            "submitted_on": job["submitted_on"],
        }
        if job["status"] == "COMPLETED":
            message["solved_on"] = job["solved_on"]
            if with_answer:
                qpu = job["type"] in ("ising", "qubo")
                if job["type"] == "nl":
                    message["answer"] = self.answer_nonlinear(number, job)
                else:
                    message["answer"] = self.answer_qpu(job) if qpu else self.answer_hybrid(job)
        return message

    def post(self, body):
        out = []
        for job in body:
            number = str(uuid4())
            job |= {"status": "PENDING", "submitted_on": now(), "begun": time.time()}
            self.problems[number] = job
            self.posted += 1
            out.append(self.message(number))
        return out


class Handler(BaseHTTPRequestHandler):
    sapi: Sapi

    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def reply(self, data, code=200):
        kind = self.headers.get("Accept", "application/json").split(",")[0].split(";")[0]
        body = json.dumps(data).encode()
        self.send_response(code)
        version = self.headers.get("Accept", "")
        self.send_header(
            "Content-Type", f"{kind}; version=3.0.0" if "vnd.dwave" in version else kind
        )
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def body(self):
        data = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        return zlib.decompress(data) if self.headers.get("Content-Encoding") else data

    def gate(self):
        self.sapi.tokens.append(self.headers.get("X-Auth-Token"))
        if self.sapi.refuse:
            token = self.headers.get("X-Auth-Token")
            self.body()
            self.reply({"error_code": 401, "error_msg": f"Invalid token={token}"}, 401)
        return not self.sapi.refuse

    def do_GET(self):
        if not self.gate():
            return None
        path, _, query = self.path.partition("?")
        parts = [part for part in path.split("/") if part]
        if parts[0] == "solvers":
            named = [s for s in self.sapi.solvers if s["identity"]["name"] in self.path]
            return self.reply(named[0] if named else self.sapi.solvers)
        if parts[0] == "answers":
            data = self.sapi.answers[parts[1]]
            self.send_response(200)
            self.send_header("Content-Length", str(len(data)))
            self.end_headers()
            return self.wfile.write(data)
        if parts[-1] == "status":
            data = self.sapi.uploads[parts[2]]
            known = [{"part_number": 1, "checksum": hashlib.md5(data).hexdigest()}]
            state = {"status": "UPLOAD_IN_PROGRESS", "parts": known if data else []}
            return self.reply(state)
        if len(parts) > 1:
            return self.reply(self.sapi.message(parts[1], with_answer=True))
        asked = dict(pair.split("=", 1) for pair in query.split("&") if pair)
        if "label" in asked:
            found = [n for n, j in self.sapi.problems.items() if j.get("label") == asked["label"]]
        else:
            found = asked["id"].replace("%2C", ",").split(",")
        return self.reply([self.sapi.message(number) for number in found])

    def do_POST(self):
        if not self.gate():
            return None
        parts = [part for part in self.path.split("/") if part]
        body = self.body()
        if parts[0] == "problems":
            answer = self.sapi.post(json.loads(body))
            if self.sapi.deaf:  # taken, but the answer is lost
                self.close_connection = True
                self.connection.close()
                return None
            return self.reply(answer)
        if parts[-1] == "multipart":
            number = str(uuid4())
            self.sapi.uploads[number] = b""
            return self.reply({"id": number})
        return self.reply({})

    def do_PUT(self):
        if self.gate():
            parts = [part for part in self.path.split("/") if part]
            self.sapi.uploads[parts[2]] += self.body()
            self.reply({})

    def do_DELETE(self):
        if self.gate():
            numbers = json.loads(self.body() or b"[]") or [self.path.split("/")[-1]]
            for number in numbers:
                self.sapi.problems[number]["status"] = "CANCELLED"
            one = "problems+json" not in self.headers.get("Accept", "")
            out = [self.sapi.message(number) for number in numbers]
            self.reply(out[0] if one else out)


@contextmanager
def serving():
    sapi = Sapi()

    class Server(ThreadingHTTPServer):
        request_queue_size = 128  # the SDK connects from many threads at once

        def handle_error(self, request, client_address):
            if not isinstance(sys.exc_info()[1], ConnectionError):  # a client may be killed
                sapi.errors.append(traceback.format_exc())

    server = Server(("127.0.0.1", 0), type("OneHandler", (Handler,), {"sapi": sapi}))
    thread = threading.Thread(
        target=server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True
    )
    thread.start()
    sapi.url = f"http://127.0.0.1:{server.server_port}/"
    try:
        yield SimpleNamespace(sapi=sapi, url=sapi.url)
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
    assert not sapi.errors, sapi.errors[0]
