"""The list of what the packages are made of (cmake/package/sbom.py) is SPDX, whole, and the same each time.
SCANKNIT_SOURCE names the checkout."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["SCANKNIT_SOURCE"])
LOCK = SOURCE / "view/page/package-lock.json"
LOCKS = [LOCK, SOURCE / "tests/package-lock.json", SOURCE / "tests/browser/package-lock.json"]
# Packages of quickstart.sh that make the program and are not in it.
TOOLS = {"ccache", "cmake", "g++", "ninja-build", "pkg-config", "esbuild"}


def written(**variables):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder, "sbom.json")
        subprocess.run([sys.executable, "-B", SOURCE / "cmake/package/sbom.py", "1.2.3", "2026-01-31", LOCK, out], check=True,
                       env=os.environ | variables)
        return out.read_bytes()


class Sbom(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.document = json.loads(written())
        cls.packages = {package["name"]: package for package in cls.document["packages"]}

    def test_has_the_fields_that_spdx_asks_for(self):
        for name, value in (("spdxVersion", "SPDX-2.3"), ("dataLicense", "CC0-1.0"), ("SPDXID", "SPDXRef-DOCUMENT")):
            self.assertEqual(self.document[name], value)
        self.assertRegex(self.document["documentNamespace"], r"^https://[^#]+$")
        self.assertRegex(self.document["creationInfo"]["created"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        self.assertTrue(self.document["creationInfo"]["creators"])
        identities = [package["SPDXID"] for package in self.document["packages"]]
        self.assertEqual(len(identities), len(set(identities)))
        for package in self.document["packages"]:
            self.assertRegex(package["SPDXID"], r"^SPDXRef-[A-Za-z0-9.-]+$")
            self.assertTrue(package["name"] and package["versionInfo"] and package["downloadLocation"])
            self.assertFalse(package["filesAnalyzed"])
            self.assertRegex(package["licenseDeclared"], r"^[A-Za-z0-9.-]+( (AND|OR|WITH) [A-Za-z0-9.-]+)*$")
        known = {*identities, "SPDXRef-DOCUMENT"}
        for relation in self.document["relationships"]:
            self.assertLessEqual({relation["spdxElementId"], relation["relatedSpdxElement"]}, known)
        related = {relation["relatedSpdxElement"] for relation in self.document["relationships"]}
        self.assertEqual(related, set(identities), "each package is described or used")

    def test_names_each_of_our_packages(self):
        table = (SOURCE / "docs/packages.md").read_text(encoding="utf-8").split("## Debian packages")[1].split("\n\n")[1]
        ours = re.findall(r"(?m)^\| `([a-z0-9-]+)`", table)
        self.assertGreaterEqual(len(ours), 4)
        self.assertLessEqual(set(ours), set(self.packages))

    def test_names_each_library_with_the_version_that_is_installed(self):
        listed = re.search(r"required_packages=\((.*?)\)", (SOURCE / "quickstart.sh").read_text(encoding="utf-8"), re.DOTALL)[1].split()
        self.assertLessEqual(set(listed) - TOOLS, set(self.packages), "one is not in cmake/package/sbom.py, or not installed")
        for name in set(listed) - TOOLS:
            asked = subprocess.run(["dpkg-query", "-W", "-f=${Version}", name], capture_output=True, text=True, check=True)
            self.assertEqual(self.packages[name]["versionInfo"], asked.stdout)

    def test_names_each_script_with_its_hash(self):
        entries = json.loads(LOCK.read_text(encoding="utf-8"))["packages"]
        names = {place.rpartition("node_modules/")[2] for place in entries if place}
        self.assertIn("three", names)
        for name in names:
            (checksum,) = self.packages[name]["checksums"]
            self.assertEqual(checksum["algorithm"], "SHA512")
            self.assertRegex(checksum["checksumValue"], "^[0-9a-f]{128}$")

    def test_is_the_same_each_time(self):
        self.assertEqual(written(), written())
        self.assertIn(b'"created": "2001-09-09T01:46:40Z"', written(SOURCE_DATE_EPOCH="1000000000"))


class Scripts(unittest.TestCase):
    def test_of_others_have_hashes_that_npm_checks(self):
        for lock in LOCKS:
            for place, entry in json.loads(lock.read_text(encoding="utf-8"))["packages"].items():
                if place and not entry.get("link"):
                    self.assertRegex(entry.get("integrity", ""), r"^sha512-[A-Za-z0-9+/]{86}==$", f"{lock}: {place}")

    def test_of_others_are_not_in_the_repository(self):
        listed = subprocess.run(["git", "ls-files"], cwd=SOURCE, capture_output=True, text=True, check=False)
        if listed.returncode:
            self.skipTest("no git checkout")
        self.assertEqual([name for name in listed.stdout.splitlines() if re.search(r"\.min\.|(^|/)(vendor|third_party|node_modules)/", name)], [])


if __name__ == "__main__":
    unittest.main()
