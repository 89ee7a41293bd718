#!/usr/bin/env python3
"""The documentation's lines are at most 140 characters long, and every key of the configuration that it names exists.

Code blocks may be longer. Keys are those of the lists in docs/configuration.md, which another test compares with the
program; a name of docs/report.md's tables may look like one.
check_text.py SOURCE_DIR; with --self-test it checks itself on pages that are wrong.
"""

import pathlib
import re
import tempfile

import checker

MOST_CHARACTERS = 140
KEY = re.compile(r"`((?:acquire|fusion|extract|finish|export|turntable)\.[a-z0-9_.]*[a-z0-9_])(?=[`:= ])")
NAMES = re.compile(r"^(?:- \*\*|\| *)(`[^|*]*`)(?:\*\*| *\|)", re.MULTILINE)  # of items and rows


def pages(root):
    return [page for page in sorted(root.rglob("*.md"))
            if not {"build", "node_modules", "out"} & set(page.relative_to(root).parts)]


def known_keys(root):
    names = set()
    for page in (root / "docs/configuration.md", root / "docs/report.md"):
        for begin in NAMES.findall(page.read_text(encoding="utf-8")):
            names.update(re.findall(r"`([^`]+)`", begin))
    sections = {name.rpartition(".")[0] for name in names}
    return names | sections


def errors(root):
    known = known_keys(root)
    for page in pages(root):
        where = page.relative_to(root)
        for number, line in checker.text_lines(page):
            if len(line) > MOST_CHARACTERS and not line.startswith("    "):
                yield f"{where}:{number}: {len(line)} characters, expected at most {MOST_CHARACTERS}"
            for key in KEY.findall(line):
                if key not in known and not key.endswith(".yaml"):
                    yield f"{where}:{number}: no such key: {key}"
    if not known:
        yield "no key at all"


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "docs").mkdir()
        long = "x" * MOST_CHARACTERS
        (root / "docs/configuration.md").write_text(
            "- **`fusion.truncation`** (2..64 voxels; default 4): what it is\n- **`fusion.noise.floor`** (0..1 m): likewise\n")
        (root / "docs/report.md").write_text("| `turntable.turns` | number |\n")
        (root / "good.md").write_text(
            f"{long}\n```\n{long} y `fusion.none`\n```\n    {long}\n"
            "`fusion.truncation`, `fusion.truncation=3`, `fusion.truncation: 3`, `turntable.turns`, `turntable.yaml`, `fusion.noise`\n")
        assert list(errors(root)) == [], list(errors(root))
        (root / "bad.md").write_text(f"{long}y\n| {long} |\n`fusion.truncation_voxels`\n`finish.none: full`\n`export.none=1`\n| `extract.none` |\n")
        found = list(errors(root))
        assert [line.split(":")[1] for line in found] == ["1", "2", "3", "4", "5", "6"], found


if __name__ == "__main__":
    checker.main(errors, self_test, "the lines are short enough, and the keys exist")
