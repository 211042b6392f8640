"""Check the internal links of a built site: `python docs/_links.py FOLDER`.

Each must lead to a file and, if it has a fragment, to an id in that file.
"""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """A page of the site.

    Attributes
    ----------
    links : set of str
        Targets of its links.
    ids : set of str
        Ids of its elements.
    """

    def __init__(self, path):
        super().__init__()
        self.links = set()
        self.ids = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.add(value)
            elif name in ("id", "name") and value:
                self.ids.add(value)


def dead_links(folder):
    """Return [(page, link)] of all dead links."""
    pages = {path: Page(path) for path in folder.rglob("*.html")}
    dead = []
    for path, page in pages.items():
        for link in sorted(page.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            is_alive = target.exists() and (
                not parts.fragment
                or target not in pages
                or unquote(parts.fragment) in pages[target].ids
            )
            if not is_alive:
                dead.append((path.relative_to(folder), link))
    return dead


if __name__ == "__main__":
    dead = dead_links(Path(sys.argv[1]).resolve())
    sys.exit("\n".join(f"{page}: dead link {link}" for page, link in dead) or None)
