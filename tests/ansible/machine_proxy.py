"""A proxy for a machine's apt: packages are kept, so that a second session fetches none."""

from __future__ import annotations

import http.server
import os
import threading
import urllib.error
import urllib.request
from pathlib import Path
from urllib.parse import urlsplit


class Handler(http.server.BaseHTTPRequestHandler):
    """Answers GET with a whole address, as apt asks a proxy."""

    keep: Path

    def do_GET(self) -> None:
        kept = None
        if self.path.endswith(".deb"):
            kept = self.keep / urlsplit(self.path).path.rsplit("/", 1)[-1].replace("%3a", "_")
        try:
            if kept is None or not kept.is_file():
                with urllib.request.urlopen(self.path, timeout=60) as answer:
                    body = answer.read()
                if kept is not None:
                    part = kept.with_name(f".{kept.name}.{os.getpid()}.{threading.get_ident()}")
                    part.write_bytes(body)
                    part.replace(kept)
            else:
                body = kept.read_bytes()
        except urllib.error.HTTPError as error:
            self.send_error(error.code)
            return
        except OSError:
            self.send_error(502)
            return
        self.send_response(200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *arguments: object) -> None:
        """Say nothing."""


def serve(address: str, keep: Path) -> http.server.ThreadingHTTPServer:
    """Start the proxy at a free port; `shutdown` and `server_close` end it."""
    keep.mkdir(parents=True, exist_ok=True)
    server = http.server.ThreadingHTTPServer(
        (address, 0), type("Kept", (Handler,), {"keep": keep, "protocol_version": "HTTP/1.1"})
    )
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server
