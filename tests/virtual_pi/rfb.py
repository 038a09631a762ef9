"""The first frame of a VNC server, by RFC 6143 (the RFB protocol), kept as a picture."""

from __future__ import annotations

import socket
import struct
import zlib
from pathlib import Path
from typing import Any


def _take(stream: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count:
        part = stream.recv(min(65536, count - len(data)))
        if not part:
            raise ConnectionError(f"the server closed after {len(data)} of {count} bytes")
        data += part
    return data


def first_frame(host: str, port: int, picture: Path, timeout: float = 120) -> dict[str, Any]:
    """Return the size of the screen and how many bytes and colours the first frame had.

    Raises
    ------
    ConnectionError
        When the server wants a password, or closes.
    """
    with socket.create_connection((host, port), timeout=timeout) as stream:
        version = _take(stream, 12)
        stream.sendall(b"RFB 003.008\n")
        kinds = _take(stream, _take(stream, 1)[0])
        if 1 not in kinds:
            raise ConnectionError(f"the server wants a login: security types {list(kinds)}")
        stream.sendall(b"\x01")
        if _take(stream, 4) != bytes(4):
            raise ConnectionError("the server refused")
        stream.sendall(b"\x01")
        width, height = struct.unpack(">HH", _take(stream, 4))
        _take(stream, 16)
        name = _take(stream, struct.unpack(">I", _take(stream, 4))[0]).decode()
        # 32 bits a pixel, true colour: blue, green, red, nothing; then the raw encoding.
        stream.sendall(struct.pack(">B3x4B3H3B3x", 0, 32, 24, 0, 1, 255, 255, 255, 16, 8, 0))
        stream.sendall(struct.pack(">BxHi", 2, 1, 0))
        stream.sendall(struct.pack(">BBHHHH", 3, 0, 0, 0, width, height))
        screen = bytearray(width * height * 4)
        got = 0
        while got < len(screen):
            kind = _take(stream, 1)[0]
            if kind == 0:  # FramebufferUpdate
                for _ in range(struct.unpack(">xH", _take(stream, 3))[0]):
                    x, y, w, h, encoding = struct.unpack(">HHHHi", _take(stream, 12))
                    if encoding != 0:
                        raise ConnectionError(f"encoding {encoding} was not asked for")
                    rows = _take(stream, w * h * 4)
                    for row in range(h):
                        at = ((y + row) * width + x) * 4
                        screen[at : at + w * 4] = rows[row * w * 4 : (row + 1) * w * 4]
                    got += w * h * 4
            elif kind == 2:  # Bell
                continue
            elif kind == 3:  # ServerCutText
                _take(stream, struct.unpack(">3xI", _take(stream, 7))[0])
            else:
                raise ConnectionError(f"message {kind} was not expected")
    _png(picture, width, height, screen)
    colours = len({bytes(screen[at : at + 3]) for at in range(0, len(screen), 4)})
    return {
        "version": version.decode().strip(), "name": name, "width": width, "height": height,
        "bytes": got, "colours": colours,
    }  # fmt: skip


def _png(path: Path, width: int, height: int, screen: bytearray) -> None:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    rows = bytearray()
    for y in range(height):
        rows.append(0)
        for x in range(width):
            at = (y * width + x) * 4
            rows += bytes((screen[at + 2], screen[at + 1], screen[at]))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = (
        chunk(b"IHDR", head),
        chunk(b"IDAT", zlib.compress(bytes(rows))),
        chunk(b"IEND", b""),
    )
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts))
