"""What the checkers of the documentation share."""

import pathlib
import sys


def text_lines(page):
    """The numbered lines outside of code blocks."""
    is_code = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            is_code = not is_code
        elif not is_code:
            yield number, line


def main(errors, self_test, all_well):
    """Runs CHECKER FOLDER, or CHECKER --self-test. `errors` gives the lines to print of a folder; none: `all_well`."""
    if "--self-test" in sys.argv:
        self_test()
        print("the checker finds what is wrong")
        return
    problems = list(errors(pathlib.Path(sys.argv[1]).resolve()))
    print("\n".join(problems) or all_well)
    sys.exit(1 if problems else 0)
