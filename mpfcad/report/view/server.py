"""A server for this machine alone: pages and files of exports, behind a random token."""

import mimetypes
import secrets
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit

from mpfcad.report.view.gallery import comparison_page, gallery_page

#: Pages draw with scripts of their own (plotly compiles some); nothing may be asked elsewhere.
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src data:; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
#: Shown in the browser; every other file is handed over to be kept.
SHOWN = (".html", ".json", ".png", ".csv", ".toml", ".svg", ".pdf", ".xml")


class ViewServer(ThreadingHTTPServer):
    """Serves a folder at `address` until it is shut down.

    It listens on 127.0.0.1 only. Requests without the token, for another host's name, or for what
    is not in the folder get 404: links that lead outside and hidden files among them.
    """

    daemon_threads = True

    def __init__(self, folder: Path, port: int = 0) -> None:
        self.folder = Path(folder).resolve()
        self.token = secrets.token_urlsafe(18)
        super().__init__(("127.0.0.1", port), _Handler)

    @property
    def address(self) -> str:
        """The gallery's address, token and all."""
        return f"http://127.0.0.1:{self.server_port}/{self.token}/"

    def names(self) -> tuple[str, ...]:
        """Return the names that a request may call this host by."""
        return (f"127.0.0.1:{self.server_port}", f"localhost:{self.server_port}")

    def find(self, place: str) -> Path | None:
        """Return the file at `place`; None where it is none of the folder's."""
        parts = [part for part in place.split("/") if part]
        if any(part.startswith(".") or "\\" in part or "\0" in part for part in parts):
            return None
        try:
            path = self.folder.joinpath(*parts).resolve()
        except OSError:
            return None
        return path if path.is_relative_to(self.folder) and path.is_file() else None


class _Handler(BaseHTTPRequestHandler):
    server: ViewServer
    server_version = "mpfcad"
    sys_version = ""

    def do_GET(self) -> None:
        """Answer with a page or a file."""
        self._answer(with_content=True)

    def do_HEAD(self) -> None:
        """Answer without the content."""
        self._answer(with_content=False)

    def _answer(self, *, with_content: bool) -> None:
        status, kind, content, kept = HTTPStatus.NOT_FOUND, "text/plain", b"not found\n", None
        found = self._content()
        if found is not None:
            status, (kind, content, kept) = HTTPStatus.OK, found
        self.send_response(status)
        charset = "; charset=utf-8" if kind.startswith("text/") or kind.endswith("json") else ""
        headers = {"Content-Type": kind + charset, "Content-Length": str(len(content)), **HEADERS}
        if kept:
            headers["Content-Disposition"] = f'attachment; filename="{kept}"'
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        if with_content:
            self.wfile.write(content)

    def _content(self) -> tuple[str, bytes, str | None] | None:
        """Return kind, content, and the name to keep it under if it is not shown."""
        address = urlsplit(self.path)
        _, _, rest = address.path.partition("/")
        token, _, place = unquote(rest).partition("/")
        known = secrets.compare_digest(token.encode(), self.server.token.encode())
        if not known or self.headers.get("Host", "") not in self.server.names():
            return None
        if place == "":
            return "text/html", gallery_page(self.server.folder).encode(), None
        if place == "pair":
            page = comparison_page(self.server.folder, parse_qs(address.query).get("run", []))
            return None if page is None else ("text/html", page.encode(), None)
        path = self.server.find(place)
        if path is None:
            return None
        kind = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
        return kind, path.read_bytes(), None if path.suffix in SHOWN else path.name

    def log_message(self, format: str, *arguments: Any) -> None:
        """Say nothing: the terminal shows the address alone."""
