"""LiteRT: a network of two layers from a .tflite file, without TensorFlow.

The file was put together from LiteRT's own schema; ``tests/health/small_network.py`` does it
again and a test holds that the bytes are these.
"""

import base64

import numpy as np

from qrobot.health.check import Check

WEIGHTS = ((0.5, -1.25, 0.75), (1.5, 0.25, -0.5), (-0.75, 1.0, 0.125), (0.25, 0.5, -1.0))
BIAS = (0.125, -0.25, 0.5, 0.0)
NEXT_WEIGHTS = ((1.0, -0.5, 0.25, 2.0), (-1.5, 0.75, 0.5, -0.25))
NEXT_BIAS = (0.1, -0.3)
INPUTS = ((0.3, -0.7, 1.1), (-1.0, 0.4, 0.2), (2.0, 1.0, -0.5))

NETWORK = (
    "GAAAAFRGTDMAAA4AFAAQAAwACAAAAAQADgAAABAAAADIAAAADAMAAAMAAAAFAAAAtAAAAHQAAABMAAAAHAAAAAQAAACi"
    "////BAAAAAgAAADNzMw9mpmZvrb///8EAAAAIAAAAAAAgD8AAAC/AACAPgAAAEAAAMC/AABAPwAAAD8AAIC+4v///wQA"
    "AAAQAAAAAAAAPgAAgL4AAAA/AAAAAAAABgAIAAQABgAAAAQAAAAwAAAAAAAAPwAAoL8AAEA/AADAPwAAgD4AAAC/AABA"
    "vwAAgD8AAAA+AACAPgAAAD8AAIC/dP///wEAAAAQAAAADAAUABAADAAIAAQADAAAABAAAADYAAAA3AAAAOAAAAADAAAA"
    "jAAAAEQAAAAQAAAAAAAKABAADAAIAAQACgAAAAwAAAAQAAAAAQAAAAEAAAAHAAAAAQAAAAYAAAAAAA4AFAAAABAADAAL"
    "AAQADgAAABQAAAAAAAAIEAAAABQAAAAEAAQABAAAAAEAAAAGAAAAAwAAAAMAAAAEAAAABQAAAAAADgAWAAAAEAAMAAsA"
    "BAAOAAAAGAAAAAAAAAgYAAAAHAAAAAAABgAIAAcABgAAAAAAAAEBAAAAAwAAAAMAAAAAAAAAAQAAAAIAAAABAAAABwAA"
    "AAEAAAAAAAAACAAAACABAADsAAAAvAAAAJgAAABwAAAATAAAACgAAAAEAAAADP///wgAAAAMAAAAAQAAAHkAAAACAAAA"
    "AQAAAAIAAAAs////CAAAAAwAAAABAAAAegAAAAIAAAABAAAAAgAAAHz///8MAAAABAAAAAwAAAACAAAAYjIAAAEAAAAC"
    "AAAAnP///wwAAAADAAAADAAAAAIAAABXMgAAAgAAAAIAAAAEAAAAkP///wgAAAAMAAAAAQAAAGgAAAACAAAAAQAAAAQA"
    "AADg////DAAAAAIAAAAMAAAAAgAAAGIxAAABAAAABAAAAAwAEAAMAAAACAAEAAwAAAAMAAAAAQAAAAwAAAACAAAAVzEA"
    "AAIAAAAEAAAAAwAAAAwADAAIAAAAAAAEAAwAAAAIAAAADAAAAAEAAAB4AAAAAgAAAAEAAAADAAAAAgAAACAAAAAEAAAA"
    "9P///w4AAAAAAAAODAAMAAsAAAAAAAQADAAAAAkAAAAAAAAJ"
)
"""The file, 864 bytes, in base64."""


def answer() -> list[float]:
    """Return the two outputs for each of the inputs."""
    from ai_edge_litert.interpreter import Interpreter

    network = Interpreter(model_content=base64.b64decode(NETWORK), num_threads=1)
    network.allocate_tensors()
    (source,), (target,) = network.get_input_details(), network.get_output_details()
    numbers: list[float] = []
    for values in INPUTS:
        network.set_tensor(source["index"], np.array([values], dtype=np.float32))
        network.invoke()
        numbers += network.get_tensor(target["index"])[0].tolist()
    return numbers


def expected() -> list[float]:
    """Return ``logistic(V relu(W x + b) + c)`` of each."""
    hidden = np.maximum(np.array(INPUTS) @ np.array(WEIGHTS).T + np.array(BIAS), 0)
    outs = hidden @ np.array(NEXT_WEIGHTS).T + np.array(NEXT_BIAS)
    return [float(value) for value in (1 / (1 + np.exp(-outs))).ravel()]


CHECK = Check(
    __name__,
    title="a network of two layers",
    group="science",
    imports=("ai_edge_litert.interpreter",),
    distributions=("ai-edge-litert",),
    source="the layers in numpy; the tolerance is for 32 bit numbers",
    tolerance=1e-5,
    extra="science",
)
