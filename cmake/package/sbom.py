#!/usr/bin/env python3
"""Writes what the packages are made of, as SPDX 2.3 in JSON.

    sbom.py VERSION DATE LOCK OUT    LOCK: view/page/package-lock.json

Versions of Debian packages are those that are installed here: dpkg-query says them. The same machine and the same
sources give the same bytes: the date is the release's, or SOURCE_DATE_EPOCH's.
"""

import base64
import datetime
import hashlib
import json
import os
import pathlib
import subprocess
import sys

APACHE = "Apache-2.0"
# Our packages (docs/packages.md), and what of the libraries below only they use.
OURS = {"scanknit": (), "libscanknit-dev": (), "python3-scanknit": ("pybind11-dev", "python3-dev"),
        "scanknit-openni2": ("libopenni2-dev",), "scanknit-step": ("libocct-data-exchange-dev",)}
# Debian packages that are linked with, or whose headers are compiled in: their licences as SPDX writes them.
LIBRARIES = {
    "libboost-dev": "BSL-1.0",
    "libbz2-dev": "bzip2-1.0.6",
    "libc6-dev": "LGPL-2.1-or-later",
    "libcli11-dev": "BSD-3-Clause",
    "libeigen3-dev": "MPL-2.0",
    "libfmt-dev": "MIT",
    "libfreenect-dev": "Apache-2.0 OR GPL-2.0-only",
    "libgdcm-dev": "BSD-3-Clause",
    "libhwy-dev": APACHE,
    "libinsighttoolkit5-dev": APACHE,
    "libjpeg62-turbo-dev": "IJG AND BSD-3-Clause AND Zlib",
    "libkainjow-mustache-dev": "BSL-1.0",
    "liblz4-dev": "BSD-2-Clause",
    "libmeshoptimizer-dev": "MIT",
    "libocct-data-exchange-dev": "LGPL-2.1-only WITH OCCT-exception-1.0",
    "libopencv-dev": APACHE,
    "libopenni2-dev": APACHE,
    "libopenvdb-dev": "MPL-2.0",
    "libpcl-dev": "BSD-3-Clause",
    "libpng-dev": "libpng-2.0",
    "libqrcodegencpp-dev": "MIT",
    "libspdlog-dev": "MIT",
    "libstdc++6": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "libtbb-dev": APACHE,
    "libtinygltf-dev": "MIT",
    "libusb-1.0-0-dev": "LGPL-2.1-or-later",
    "libyaml-cpp-dev": "MIT",
    "libzstd-dev": "BSD-3-Clause OR GPL-2.0-only",
    "nlohmann-json3-dev": "MIT",
    "pybind11-dev": "BSD-3-Clause",
    "python3-dev": "PSF-2.0",
    "zlib1g-dev": "Zlib",
}
UNKNOWN = "NOASSERTION"


def installed_version(name):
    try:
        asked = subprocess.run(["dpkg-query", "-W", "-f=${Version}\n", name], capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return None
    return asked.stdout.splitlines()[0] if asked.returncode == 0 and asked.stdout.strip() else None


def id_of(kind, name):
    return f"SPDXRef-{kind}-" + "".join(letter if letter.isalnum() or letter in ".-" else "-" for letter in name)


def package(kind, name, version, licence, locator=None, checksum=None):
    described = {"SPDXID": id_of(kind, name), "name": name, "versionInfo": version, "downloadLocation": UNKNOWN,
                 "filesAnalyzed": False, "licenseConcluded": licence, "licenseDeclared": licence, "copyrightText": UNKNOWN}
    if locator:
        described["externalRefs"] = [
            {"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": locator}]
    if checksum:
        described["checksums"] = [{"algorithm": "SHA512", "checksumValue": checksum}]
    return described


def libraries():
    for name, licence in LIBRARIES.items():
        version = installed_version(name)
        if version:  # what is not here is not in the packages
            locator = f"pkg:deb/debian/{name.replace('+', '%2B')}@{version.replace('+', '%2B').replace(':', '%3A')}"
            yield package("Debian", name, version, licence, locator)


def scripts(lock):
    """What `npm ci` installs for the live view's page, each with the hash that it checks."""
    for place, entry in json.loads(lock.read_text(encoding="utf-8"))["packages"].items():
        if place == "" or entry.get("dev"):
            continue
        name = place.rpartition("node_modules/")[2]
        kind, _, digest = entry["integrity"].partition("-")
        if kind != "sha512":
            raise ValueError(f"{lock}: {name} has a hash of kind {kind}, expected sha512")
        yield package("npm", name, entry["version"], entry["license"], f"pkg:npm/{name.replace('@', '%40')}@{entry['version']}",
                      base64.b64decode(digest).hex())


def date_of(release):
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if epoch:
        return datetime.datetime.fromtimestamp(int(epoch), datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    return f"{datetime.date.fromisoformat(release) if release[:1].isdigit() else datetime.date(1970, 1, 1)}T00:00:00Z"


def document(version, release, lock):
    ours = [package("ScanKnit", name, version, APACHE) for name in OURS]
    used, bundled = list(libraries()), list(scripts(lock))
    of_some = {library: name for name, libraries_of in OURS.items() for library in libraries_of}
    relations = [("SPDXRef-DOCUMENT", "DESCRIBES", each["SPDXID"]) for each in ours]
    relations += [(id_of("ScanKnit", of_some.get(each["name"], "scanknit")), "DEPENDS_ON", each["SPDXID"]) for each in used]
    relations += [(id_of("ScanKnit", "scanknit"), "CONTAINS", each["SPDXID"]) for each in bundled]
    relations += [(id_of("ScanKnit", name), "DEPENDS_ON", id_of("ScanKnit", "scanknit")) for name in OURS if name != "scanknit"]
    packages = ours + used + bundled
    content = hashlib.sha256(json.dumps(packages, sort_keys=True).encode()).hexdigest()
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"scanknit-{version}",
        "documentNamespace": f"https://spdx.org/spdxdocs/scanknit-{version}-{content[:32]}",
        "creationInfo": {"created": date_of(release), "creators": [f"Tool: scanknit-sbom-{version}"]},
        "packages": packages,
        "relationships": [{"spdxElementId": subject, "relationshipType": kind, "relatedSpdxElement": related}
                          for subject, kind, related in relations],
    }


def main():
    version, release, lock, out = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3]), pathlib.Path(sys.argv[4])
    out.write_text(json.dumps(document(version, release, lock), indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
