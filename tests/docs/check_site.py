#!/usr/bin/env python3
"""The built site: every link leads to a file and an anchor that are there, nothing is fetched from other hosts, and no
Markdown was left as it was.

check_site.py SITE_DIR; with --self-test it checks itself on pages that are wrong.
"""

import html.parser
import pathlib
import re
import tempfile

import checker
import urllib.parse

OTHER_HOST = re.compile(r"(?:[a-z]+:)?//", re.IGNORECASE)
NOT_FETCHED = {"canonical", "prev", "next"}  # <link rel=...> that only names something
LEFT_OVER = re.compile(r"^\s*(?:[-*] |\d+\. |\||```|#+ )|\]\(", re.MULTILINE)


class Page(html.parser.HTMLParser):
    """What a page has that can be led to, what it leads to, what it fetches, and the text of its paragraphs."""

    def __init__(self, path):
        super().__init__(convert_charrefs=True)
        self.anchors, self.links, self.fetched, self.paragraphs = set(), [], [], []
        self.is_in_paragraph, self.code_depth = False, 0
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        if given.get("id"):
            self.anchors.add(given["id"])
        if tag == "a" and given.get("name"):
            self.anchors.add(given["name"])
        if tag == "a" and given.get("href") is not None:
            self.links.append(given["href"])
        if given.get("src"):
            self.fetched.append(given["src"])
        if tag == "link" and given.get("href") and given.get("rel") not in NOT_FETCHED:
            self.fetched.append(given["href"])
        if tag == "p":
            self.is_in_paragraph = True
            self.paragraphs.append("")
        self.code_depth += tag == "code"

    def handle_endtag(self, tag):
        self.is_in_paragraph &= tag != "p"
        self.code_depth -= tag == "code"

    def handle_data(self, text):
        if self.is_in_paragraph and not self.code_depth:
            self.paragraphs[-1] += text


def target_errors(root, page, target, pages):
    link = urllib.parse.urlsplit(target)
    if link.scheme or link.netloc or target.startswith("//"):
        return
    path = urllib.parse.unquote(link.path)
    place = page if not path else (root / path.lstrip("/") if path.startswith("/") else page.parent / path).resolve()
    if place.is_dir():
        place = place / "index.html"
    if not place.is_relative_to(root):
        yield f"{target}: leads out of the site"
    elif not place.exists():
        yield f"{target}: no such file"
    elif link.fragment and place in pages and urllib.parse.unquote(link.fragment) not in pages[place].anchors:
        yield f"{target}: no such anchor"


def page_errors(root, path, pages):
    page = pages[path]
    for target in page.links + page.fetched:
        yield from target_errors(root, path, target, pages)
    for target in page.fetched:
        if OTHER_HOST.match(target):
            yield f"{target}: fetched from another host"
    for text in page.paragraphs:
        if LEFT_OVER.search(text):
            yield f"Markdown was left as it was: {text.strip()[:80]!r}"


def style_errors(path):
    text = path.read_text(encoding="utf-8")
    for target in re.findall(r"(?:url\(|@import)\s*[\"']?([^\"')\s]+)", text):
        if OTHER_HOST.match(target):
            yield f"{target}: fetched from another host"


def errors(root):
    pages = {path: Page(path) for path in sorted(root.rglob("*.html"))}
    found = [(path, error) for path in pages for error in page_errors(root, path, pages)]
    found += [(path, error) for path in sorted(root.rglob("*.css")) for error in style_errors(path)]
    if root / "index.html" not in pages:
        found.append((root, "no index.html"))
    return [f"{path.relative_to(root)}: {error}" for path, error in found]


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder).resolve()
        (root / "sub").mkdir()
        (root / "index.html").write_text(
            '<h1 id="top">A</h1><p>well - said <code>- [x](y)</code></p><a href="sub/">a</a><a href="sub/index.html#b">b</a>'
            '<a href="#top">c</a><a href="https://example.org/">d</a><link rel="canonical" href="https://example.org/x">')
        (root / "sub/index.html").write_text('<h2 id="b">B</h2><a href="../index.html#top">up</a><img src="../p.png">')
        (root / "p.png").write_bytes(b"")
        (root / "a.css").write_text("a{background:url(p.png)} b{background:url(data:image/png,x)}")
        assert errors(root) == [], errors(root)
        for wrong in ('<a href="gone.html">', '<a href="sub/#none">', '<a href="#none">', '<a href="../x">', '<img src="no.png">',
                      '<script src="https://example.org/x.js">', '<img src="//example.org/x.png">', "<p>text\n- item</p>",
                      '<link rel="stylesheet" href="https://example.org/x.css">', "<p>[a](b.md)</p>", "<p>a\n| b | c |</p>"):
            (root / "wrong.html").write_text(wrong)
            assert len(errors(root)) == 1, (wrong, errors(root))
        (root / "wrong.html").unlink()
        (root / "b.css").write_text('@import "https://example.org/x.css"; a{background:url("http://example.org/x.png")}')
        assert len(errors(root)) == 2, errors(root)


if __name__ == "__main__":
    checker.main(errors, self_test, "every link leads somewhere, and nothing is fetched from elsewhere")
