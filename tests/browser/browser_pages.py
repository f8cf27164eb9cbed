"""Helpers of all browser tests. Without a browser, these tests are skipped with a message."""

from __future__ import annotations

from base64 import b64decode, b64encode

import numpy as np
import pytest
from chromium import browser, executable

READY = "() => window.cdpr !== undefined && !window.cdpr.waiting"
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True, "device_scale_factor": 2}


@pytest.fixture(scope="module")
def chromium():
    pytest.importorskip("playwright", reason="playwright is not installed: pip install 'cdpr[test]'")
    if executable() is None:
        pytest.skip("there is no Chromium on this machine")
    with browser() as found:
        yield found


@pytest.fixture
def open_page(chromium):
    """Opens pages; none of them may report an error, or request another resource."""
    contexts, told = [], []

    def hear(message):
        # The driver warns about its speed, because tests read pixels back.
        if message.type in ("error", "warning") and "GL Driver Message (OpenGL, Performance" not in message.text:
            told.append(message.text)

    def open_one(address, ready=READY, **options):
        contexts.append(chromium.new_context(**{"viewport": {"width": 1200, "height": 800}, **options}))
        page = contexts[-1].new_page()
        page.on("console", hear)
        page.on("pageerror", lambda error: told.append(str(error)))
        itself = address.partition("#")[0]
        page.on("request", lambda asked: told.append(asked.url) if asked.url.partition("#")[0] != itself else None)
        page.goto(address)
        page.wait_for_function(ready, polling=50)
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert told == []


def pixels(page, box):
    """Red, green and blue of a part of the page, (n, 3) bytes, row by row."""
    image = page.screenshot(clip=box)
    # As text: a list of a million numbers takes twenty seconds.
    data = page.evaluate(
        """async (data) => {
          const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
          const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
          const canvas = new OffscreenCanvas(image.width, image.height), c = canvas.getContext("2d");
          c.drawImage(image, 0, 0);
          const all = c.getImageData(0, 0, image.width, image.height).data, text = [];
          for (let i = 0; i < all.length; i += 8192) text.push(String.fromCharCode(...all.subarray(i, i + 8192)));
          return btoa(text.join(""));
        }""",
        b64encode(image).decode(),
    )
    return np.frombuffer(b64decode(data), np.uint8).reshape(-1, 4)[:, :3].astype(int)
