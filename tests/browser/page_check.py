"""Layout check of any page in a browser at the widths of phones, laptops and screens: `page_check.js` looks."""

from __future__ import annotations

from pathlib import Path

WIDTHS = (390, 1200, 1280, 1366, 1440, 1920)  # px: a phone, laptops and screens
HEIGHTS = {390: 844, 1200: 900, 1280: 800, 1366: 768, 1440: 900, 1920: 1080}

PATIENCE = 180_000  # ms, on a machine that does other things besides

SCRIPT = Path(__file__).with_name("page_check.js").read_text(encoding="utf-8")
WATCH = f"(() => {{ {SCRIPT}; watchTexts(); }})()"
CHECK = f"async (width) => {{ {SCRIPT}; return checkPage(width); }}"


def screen(width):
    """Options of a browser's context for this width."""
    phone = width < 700
    return {"viewport": {"width": width, "height": HEIGHTS[width]}, "is_mobile": phone, "has_touch": phone}


def faults(page, width):
    """Return what is wrong with an open page, in sentences. WATCH must have run before it was loaded."""
    return page.evaluate(CHECK, width)


def faults_of(browser, address, width, ready="() => window.cdpr === undefined || !window.cdpr.waiting", **options):
    """Open a page at a width and check it."""
    context = browser.new_context(**screen(width), **options)
    try:
        context.set_default_timeout(PATIENCE)
        page = context.new_page()
        page.add_init_script(WATCH)
        page.goto(address)
        page.wait_for_function(ready, polling=50)
        return faults(page, width)
    finally:
        context.close()
