"""Builds the network of the check of LiteRT from LiteRT's own schema, tensor by tensor."""

from __future__ import annotations

from typing import Any

import flatbuffers
import numpy as np
from ai_edge_litert import schema_py_generated as schema

from qrobot.health.checks import litert


def build() -> bytes:
    """Return ``logistic(V relu(W x + b) + c)`` as a .tflite file."""
    layers = [litert.WEIGHTS, litert.BIAS, litert.NEXT_WEIGHTS, litert.NEXT_BIAS]
    model = schema.ModelT()
    model.version = 3
    model.buffers = [buffer(), *(buffer(np.array(numbers, "<f4")) for numbers in layers)]
    model.operatorCodes = [
        code(schema.BuiltinOperator.FULLY_CONNECTED),
        code(schema.BuiltinOperator.LOGISTIC),
    ]
    graph = schema.SubGraphT()
    graph.tensors = [
        tensor("x", [1, 3], 0), tensor("W1", [4, 3], 1), tensor("b1", [4], 2),
        tensor("h", [1, 4], 0), tensor("W2", [2, 4], 3), tensor("b2", [2], 4),
        tensor("z", [1, 2], 0), tensor("y", [1, 2], 0),
    ]  # fmt: skip
    graph.inputs, graph.outputs = [0], [7]
    kinds = schema.ActivationFunctionType
    graph.operators = [
        operator(0, [0, 1, 2], 3, kinds.RELU),
        operator(0, [3, 4, 5], 6, kinds.NONE),
        operator(1, [6], 7),
    ]
    model.subgraphs = [graph]
    builder = flatbuffers.Builder(1024)
    builder.Finish(model.Pack(builder), file_identifier=b"TFL3")
    return bytes(builder.Output())


def buffer(numbers: Any = None) -> Any:
    made = schema.BufferT()
    made.data = None if numbers is None else np.frombuffer(numbers.tobytes(), np.uint8)
    return made


def code(number: int) -> Any:
    made = schema.OperatorCodeT()
    made.builtinCode = made.deprecatedBuiltinCode = number
    made.version = 1
    return made


def tensor(name: str, shape: list[int], place: int) -> Any:
    made = schema.TensorT()
    made.name, made.shape, made.buffer = name, shape, place
    made.type = schema.TensorType.FLOAT32
    return made


def operator(which: int, sources: list[int], target: int, activation: int | None = None) -> Any:
    made = schema.OperatorT()
    made.opcodeIndex, made.inputs, made.outputs = which, sources, [target]
    if activation is not None:
        made.builtinOptionsType = schema.BuiltinOptions.FullyConnectedOptions
        made.builtinOptions = schema.FullyConnectedOptionsT()
        made.builtinOptions.fusedActivationFunction = activation
    return made
