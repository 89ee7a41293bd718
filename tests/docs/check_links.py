#!/usr/bin/env python3
"""Every link of the documentation leads somewhere: files, headings, pictures. Links to other sites are not followed.

check_links.py SOURCE_DIR; with --self-test it checks itself on pages that are wrong.
"""

import pathlib
import re
import tempfile

import checker

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)")
HEADING = re.compile(r"^#{1,6}\s+(.*?)\s*#*$")


def anchor(heading):
    """As the forges make it of a heading."""
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").lower()
    return re.sub(r"[^\w\- ]", "", words).replace(" ", "-")


def anchors(path):
    found = {}
    for _, line in checker.text_lines(path):
        match = HEADING.match(line)
        if match:
            name = anchor(match.group(1))
            count = found.get(name, 0)
            found[name] = count + 1
            yield name if count == 0 else f"{name}-{count}"


def links(path):
    for number, line in checker.text_lines(path):
        for target in LINK.findall(re.sub(r"`[^`]*`", "", line)):
            yield number, target


def errors(root):
    pages = [page for page in sorted(root.rglob("*.md"))
             if not {"build", "node_modules", "out"} & set(page.relative_to(root).parts)]
    for page in pages:
        for number, target in links(page):
            if re.match(r"[a-z]+:", target):
                continue
            name, _, heading = target.partition("#")
            place = (page.parent / name).resolve() if name else page
            where = f"{page.relative_to(root)}:{number}: {target}"
            if not place.exists():
                yield f"{where}: no such file"
            elif not place.is_relative_to(root):
                yield f"{where}: leads out of the repository"
            elif heading and heading not in set(anchors(place)):
                yield f"{where}: no such heading"
    if not pages:
        yield "no page at all"


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder).resolve()
        (root / "good.md").write_text("# A `b`: c, d\n[x](#a-b-c-d) [y](other.md#two-1)\n```\n[no](nowhere)\n```\n`[no](it)`\n")
        (root / "other.md").write_text("## Two\n## Two\n[z](https://example.org/x)\n")
        assert list(errors(root)) == [], list(errors(root))
        (root / "bad.md").write_text("[a](gone.md)\n![b](gone.png)\n[c](other.md#three)\n[d](/etc/passwd)\n[e](#none)\n")
        found = list(errors(root))
        assert [line.split(":")[1] for line in found] == ["1", "2", "3", "4", "5"], found


if __name__ == "__main__":
    checker.main(errors, self_test, "every link leads somewhere")
