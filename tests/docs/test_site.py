"""The built site in Chromium: nothing is fetched from elsewhere, nothing scrolls sideways."""

import shutil
from pathlib import Path

import pytest

pytestmark = pytest.mark.site

SITE = Path(__file__).resolve().parents[2] / "site"
NAMES = "chromium", "chromium-browser", "google-chrome", "google-chrome-stable"
CHROMIUM = next(filter(None, map(shutil.which, NAMES)), None)
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu")
WIDTHS = (390, 1280)
TOO_WIDE = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


def pages():
    """Every page but those that only show a file."""
    found = (path.relative_to(SITE) for path in sorted(SITE.rglob("*.html")))
    return [path for path in found if path.parts[0] not in ("source", "replays")]


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api", reason="Playwright comes with extra `dev`")
    assert CHROMIUM, "no Chromium on the PATH; on Debian: apt-get install chromium"
    with api.sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield found
        found.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS)
def test_no_page_scrolls_sideways_or_fetches_from_elsewhere(browser, width, scheme):
    assert len(pages()) > 50, "build the site first: make docs"
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
    tab, requests, wide = context.new_page(), [], {}
    tab.on("request", lambda request: requests.append(request.url))
    for page in pages():
        tab.goto((SITE / page).as_uri(), wait_until="domcontentloaded")
        if (over := tab.evaluate(TOO_WIDE)) > 0:
            wide[str(page)] = over
    context.close()
    assert not wide
    assert {url.partition(":")[0] for url in requests} <= {"file", "data", "blob"}
