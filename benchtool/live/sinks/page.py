"""The web viewer's page, with a policy that allows connections to this viewer only.

The page that Rerun serves reports usage to its vendor and loads fonts from elsewhere, and no option of it
prevents that. So the page is forwarded with a Content-Security-Policy (W3C CSP Level 3), which the browser
enforces.
"""

from __future__ import annotations

import http.client
import ipaddress
import shutil
import socket
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import quote

from benchtool.errors import EnvironmentFailure

_TIMEOUT_S = 10.0
_PASSED_ON = ("Content-Type", "Content-Encoding", "rerun-final-length")


def policy(sources: str) -> str:
    """Return what the page may load and whom it may connect to: itself and `sources`, as CSP names them."""
    return (
        f"default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; "
        f"connect-src 'self' {sources} data: blob:; form-action 'none'; frame-ancestors 'self'"
    )


class Page:
    """Serves the page at `bind`:`port` until it is closed.

    Args:
        bind, port: where to listen; port 0 picks a free one.
        host: by which a browser on this machine reaches what listens at `bind`.
        viewer_port: where Rerun serves the page.
        data_port: where Rerun serves the data.

    Raises:
        EnvironmentFailure: the port is in use.
    """

    def __init__(self, bind: str, port: int, host: str, viewer_port: int, data_port: int) -> None:
        # Of a wildcard others reach the data by whatever name of this machine they use.
        everybody = ipaddress.ip_address(bind).is_unspecified
        sources = f"http://*:{data_port}" if everybody else f"http://{host}:{data_port}"

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                _pass_on(self, host, viewer_port, policy(sources))

            def log_message(self, format: str, *args: object) -> None:
                """Drop the log of requests."""

        class Server(ThreadingHTTPServer):
            address_family = socket.AF_INET6 if ":" in bind else socket.AF_INET

        try:
            self._server = Server((bind, port), Handler)
        except OSError as reason:
            raise EnvironmentFailure(
                f"cannot serve the live view at {bind}:{port}: {reason.strerror}; choose another port"
            ) from None
        self._server.daemon_threads = True
        self._data_port = data_port
        # Other machines are assumed to reach this one by its host name.
        self._host = socket.gethostname() if everybody else host
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.05,), name="benchtool-page", daemon=True
        )
        self._thread.start()

    @property
    def port(self) -> int:
        return int(self._server.server_address[1])

    @property
    def url(self) -> str:
        """Address of the page, with the data that it shows."""
        data = f"rerun+http://{self._host}:{self._data_port}/proxy"
        return f"http://{self._host}:{self.port}/?url={quote(data, safe='')}&theme=dark"

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


def _pass_on(request: BaseHTTPRequestHandler, host: str, port: int, allowed: str) -> None:
    connection = http.client.HTTPConnection(host.strip("[]"), port, timeout=_TIMEOUT_S)
    try:
        connection.request("GET", request.path)
        answer = connection.getresponse()
        request.send_response(answer.status)
        for name in _PASSED_ON:
            if (value := answer.getheader(name)) is not None:
                request.send_header(name, value)
        request.send_header("Content-Security-Policy", allowed)
        request.send_header("Referrer-Policy", "no-referrer")
        request.end_headers()
        shutil.copyfileobj(answer, request.wfile, 1 << 20)
    except (OSError, http.client.HTTPException):
        request.close_connection = True  # the viewer or the browser has gone
    finally:
        connection.close()
