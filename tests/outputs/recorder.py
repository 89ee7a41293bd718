"""Runs the program and takes the SHA-256 of everything that it writes, without times and random ids."""

import dataclasses
import hashlib
import html.parser
import os
import pathlib
import re
import shlex
import subprocess

# Options that name outputs.
WRITTEN_BY = ("-o", "--report", "--trajectory", "--save-volume", "--points", "--cut-recording")
STRING = r'"(?:[^"\\]|\\.)*"'
TIME = re.compile(r'("(?:total_ms|median_ms|p95_ms|peak_rss_mib)": )([-+.0-9e]+)')
VERSION = re.compile(rf'(?m)^(  "version": ){STRING}')
WORDS = re.compile(rf'("(?:status|reason|refused|fault|description|title)": )({STRING})')
LIST_OF_WORDS = re.compile(rf'("(?:warnings|drop_messages)": )(\[\s*(?:{STRING}[\s,]*)*\])')
VDB_ID = slice(21, 57)  # OpenVDB gives each file a random id
# On processors with fused multiply-add the C library has other versions of sin, atan2, exp ..., which may round
# differently in the last bit. This makes it use the same versions on all x86-64 processors.
SAME_ON_ALL_PROCESSORS = "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4"
NO_WORDS = {"ok", ""}  # values of status, reason and refused that stay


def without_times(text):
    """A report with 1 for each time that is not 0, and without a version. All other bytes stay."""
    text = TIME.sub(lambda found: found[1] + ("0.0" if float(found[2]) == 0 else "1.0"), text)
    return VERSION.sub(r'\1""', text)


def without_words(text):
    """JSON with "?" for each text for people: their number still counts, their wording does not."""
    text = WORDS.sub(lambda found: found[1] + (found[2] if found[2][1:-1] in NO_WORDS else '"?"'), text)
    return LIST_OF_WORDS.sub(lambda found: found[1] + re.sub(STRING, '"?"', found[2]), text)


class Drawings(html.parser.HTMLParser):
    """The pictures and charts of a page: their elements with all attributes except texts for people."""

    TAGS = {"img", "svg", "rect", "line", "polyline", "polygon", "path", "circle", "g"}
    WORDS = {"alt", "title", "aria-label"}

    def __init__(self, page):
        super().__init__()
        self.found = []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        if tag in self.TAGS:
            self.found.append((tag, sorted((name, value) for name, value in attributes if name not in self.WORDS)))


def sha256(content):
    return hashlib.sha256(content if isinstance(content, bytes) else content.encode("utf-8")).hexdigest()


def content_of(path):
    content = bytearray(path.read_bytes())
    if path.suffix == ".vdb":
        content[VDB_ID] = bytes(len(content[VDB_ID]))
    return bytes(content)


def hash_of_tree(folder):
    """One hash of the names and contents of all files below a folder."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return sha256("".join(f"{path.relative_to(folder).as_posix()} {sha256(content_of(path))}\n" for path in files))


@dataclasses.dataclass
class Way:
    """How commands are run; without a name: as they are written."""
    name: str = ""
    threads: int | None = None
    variables: dict = dataclasses.field(default_factory=dict)

    # Commands that have --threads; the others compute nothing.
    THREADED = ("synth", "run", "extract", "align", "convert", "repair", "info", "distance", "report")

    def arguments(self, words):
        is_threaded = self.threads is not None and words and words[0] in self.THREADED and "--help" not in words
        return [*words, "--threads", str(self.threads)] if is_threaded else words


class Recorder:
    """Runs commands in `folder` and keeps a line for each output: in `lines["bytes"]` outputs that must never change,
    in `lines["texts"]` texts for people. A line is a value (SHA-256, exit code ...) by its name, SUITE/CASE/FILE."""

    def __init__(self, program, folder, suite, way=Way()):
        self.program, self.folder, self.suite, self.way = program, folder, suite, way
        self.lines = {"bytes": {}, "texts": {}}

    def path(self, name):
        return self.folder / name

    def call(self, arguments, stdin=""):
        environment = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
        environment |= {"NO_COLOR": "1", "LC_ALL": "C.UTF-8", "TZ": "UTC", "GLIBC_TUNABLES": SAME_ON_ALL_PROCESSORS}
        environment |= self.way.variables
        return subprocess.run([self.program, *self.way.arguments(arguments)], cwd=self.folder, env=environment, input=stdin.encode(),
                              capture_output=True, timeout=300, check=False)

    def keep(self, group, name, value):
        name = f"{self.suite}/{name}"
        if name in self.lines[group]:
            raise ValueError(f"two outputs are named {name}")
        self.lines[group][name] = value

    def keep_json(self, name, text):
        text = without_times(text)
        self.keep("bytes", name, sha256(without_words(text)))
        self.keep("texts", name, sha256(text))

    def keep_file(self, name, path):
        if path.name == "report.html":
            return  # see page()
        content = content_of(path)
        if path.suffix == ".json" and b'"peak_rss_mib"' in content:
            self.keep_json(name, content.decode("utf-8"))
        else:
            self.keep("bytes", name, sha256(content))

    def keep_output(self, case, path):
        """One line for a file, for each file of a folder that holds a report, or for any other folder."""
        if path.is_file():
            self.keep_file(f"{case}/{path.name}", path)
        elif not path.is_dir():
            self.keep("bytes", f"{case}/{path.name}", "absent")
        elif (path / "report.json").is_file():
            for file in sorted(path.rglob("*")):
                if file.is_file():
                    self.keep_file(f"{case}/{file.relative_to(path).as_posix()}", file)
        else:
            self.keep("bytes", f"{case}/{path.name}", hash_of_tree(path))

    def run(self, case, command, said=None, stdin=""):
        """Runs a command line; keeps its exit code and all files and folders that its options name as outputs. `said`
        adds stdout as "json", as "bytes" or as "text" for people, or stderr as "error". Returns stdout."""
        arguments = shlex.split(command)
        done = self.call(arguments, stdin)
        self.keep("bytes", f"{case}/exit_code", str(done.returncode))
        for option, value in zip(arguments, arguments[1:]):
            if option in WRITTEN_BY:
                self.keep_output(case, self.path(value))
        stdout = done.stdout.decode("utf-8")
        if said == "json":
            self.keep_json(f"{case}/stdout", stdout)
        elif said == "bytes":
            self.keep("bytes", f"{case}/stdout", sha256(stdout))
        elif said == "text":
            self.keep("texts", f"{case}/stdout", sha256(stdout))
        elif said == "error":
            self.keep("texts", f"{case}/stderr", sha256(done.stderr))
        return stdout

    def page(self, case, folder=None):
        """report.html of a run has times. This checks that `scanknit report` draws the same page, and keeps the page
        that it draws from a report without times."""
        folder = folder or case
        page, report = self.path(folder) / "report.html", self.path(folder) / "report.json"
        first, told = page.read_bytes(), report.read_text(encoding="utf-8")
        self.call(["report", folder])
        self.keep("bytes", f"{case}/report.html again", "same" if page.read_bytes() == first else "other")
        report.write_text(without_times(told), encoding="utf-8")
        self.call(["report", folder])
        drawn = page.read_text(encoding="utf-8")
        self.keep("bytes", f"{case}/report.html drawings", sha256(repr(Drawings(drawn).found)))
        self.keep("texts", f"{case}/report.html", sha256(drawn))
        report.write_text(told, encoding="utf-8")


class Missing(Exception):
    """Files that a suite needs are not on this computer."""


def data_folder():
    """The folder of the real recordings; tests/app/test_recordings.cpp uses the same one."""
    given = os.environ.get("SCANKNIT_TEST_DATA")
    source = pathlib.Path(__file__).resolve().parents[2]
    return pathlib.Path(given) if given else source.parent / "shared" / "data"
