"""Web pages in a browser and a run with `--live foxglove`: only one that has the token gets in."""

from __future__ import annotations

import threading
from contextlib import closing, contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import quote

import pytest
from chromium import browser, executable

foxglove = pytest.importorskip("cdpr.ui.live.foxglove")
pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(executable() is None, reason="no Chromium here"),
]

# A page that tries to steer: it sets the speed, and publishes a target.
PAGE = """<!doctype html><title>waits</title><script>
const url = new URLSearchParams(location.search).get("url");
const web = new WebSocket(url, ["foxglove.sdk.v1"]);
web.onerror = () => { document.title = "refused"; };
web.onmessage = (message) => {
  if (typeof message.data !== "string" || JSON.parse(message.data).op !== "serverInfo") return;
  web.send(JSON.stringify({op: "setParameters", parameters: [{name: "speed", value: 5}]}));
  document.title = "steered";
};
</script>"""


class Stranger(BaseHTTPRequestHandler):
    def do_GET(self):
        body = PAGE.encode()
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


@contextmanager
def strange_pages():
    """The address of another server, whose page is not ours."""
    with ThreadingHTTPServer(("127.0.0.1", 0), Stranger) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def test_a_page_of_somebody_else_does_not_steer():
    with browser() as found, strange_pages() as place, closing(foxglove.Foxglove(port=0)) as link:
        page = found.new_page()
        bare = f"ws://127.0.0.1:{link.port}"
        for url in (bare, bare.replace("127.0.0.1", "localhost"), f"{bare}/?token=", f"{bare}/?token=guessed"):
            page.goto(f"{place}?url={quote(url, safe='')}")
            page.wait_for_function("() => document.title !== 'waits'")
            assert page.title() == "refused", url
            assert link.requests.get(0.2) is None
        page.goto(f"{place}?url={quote(link.url, safe='')}")  # as Foxglove in a browser, to which the user gave it
        page.wait_for_function("() => document.title === 'steered'")
        assert link.requests.get(5.0).values == {"value": 5}
