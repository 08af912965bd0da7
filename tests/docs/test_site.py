"""The built site in Chromium: nothing is fetched from elsewhere, nothing scrolls sideways."""

from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import pytest

from tests.chromium import launched_browser  # noqa: F401 the fixture browser
from tests.rendering.replay.test_browser import LOADED, until

pytestmark = pytest.mark.site

SITE = Path(__file__).resolve().parents[2] / "site"
WIDTHS = (390, 1280)
TOO_WIDE = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


def pages():
    """Every page but those that only show a file."""
    found = (path.relative_to(SITE) for path in sorted(SITE.rglob("*.html")))
    return [path for path in found if path.parts[0] not in ("source", "replays")]


class Quiet(SimpleHTTPRequestHandler):
    """Serves the site, and writes no log."""

    def log_message(self, *arguments):
        """Say nothing."""


@pytest.fixture(scope="module")
def address():
    """Where the site is served."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=SITE)) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture
def opened(browser, address):
    """Opens a tab; in the end all that was fetched is of the site, and nothing complained."""
    contexts, requests, complaints = [], [], []

    def open_tab(**options):
        contexts.append(browser.new_context(**options))
        tab = contexts[-1].new_page()
        tab.on("request", lambda request: requests.append(request.url))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        return tab

    yield open_tab
    for context in contexts:
        context.close()
    assert requests
    own = address, SITE.as_uri(), "data:", "blob:"
    assert not [url for url in requests if not url.startswith(own)]
    assert not complaints


@pytest.mark.parametrize("width", WIDTHS)
def test_no_page_scrolls_sideways(opened, address, width):
    assert len(pages()) > 50, "build the site first: make docs"
    tab, wide = opened(viewport={"width": width, "height": 900}, color_scheme="dark"), {}
    for page in pages():
        tab.goto(address + page.as_posix(), wait_until="domcontentloaded")
        if (over := tab.evaluate(TOO_WIDE)) > 0:
            wide[page.as_posix()] = over
    assert not wide


@pytest.mark.parametrize("is_served", [True, False])
def test_the_site_can_be_searched(opened, address, is_served):
    tab = opened(viewport={"width": 1280, "height": 900})
    tab.goto(address if is_served else f"{SITE.as_uri()}/index.html")
    tab.fill("input[name=query]", "round trip")
    tab.wait_for_selector(".md-search-result__item")


def test_the_page_on_the_front_page_runs_a_world(opened, address):
    tab = opened(viewport={"width": 1280, "height": 900})
    tab.goto(address)
    page = next(frame for frame in tab.frames if "replays/play" in frame.url)
    until(page, LOADED)
    before = page.text_content("#clock")
    page.click("#play")
    until(page, f"element('clock').textContent !== {before!r}")
