#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the list of package contents: the fields required by SPDX 2.3, each package's checksum.

  check_contents.py LIST DEB...
"""
import hashlib
import json
import pathlib
import re
import sys

REQUIRED = {"": ("SPDXID", "spdxVersion", "dataLicense", "name", "documentNamespace", "creationInfo"),
            "creationInfo": ("created", "creators"),
            "packages": ("SPDXID", "name", "downloadLocation"),
            "relationships": ("spdxElementId", "relationshipType", "relatedSpdxElement")}
# A header-only library, a shared one, and one that is bundled into a program.
EXPECTED = {("vdrived", "STATIC_LINK", "libeigen3-dev"), ("vdrived", "DYNAMIC_LINK", "libyaml-cpp-dev"),
            ("vdrive-gateway", "CONTAINS", "uplot"), ("python3-vdrive", "STATIC_LINK", "pybind11-dev")}


def missing_fields(document):
    for field, names in REQUIRED.items():
        rows = document[field] if field else document
        for row in rows if isinstance(rows, list) else [rows]:
            for name in names:
                if not row.get(name):
                    yield f"{field or 'the document'} has no {name}: {row}"


def wrong_values(document):
    if (document["spdxVersion"], document["dataLicense"]) != ("SPDX-2.3", "CC0-1.0"):
        yield f"version {document['spdxVersion']}, licence {document['dataLicense']}"
    if not re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", document["creationInfo"]["created"]):
        yield f"created: {document['creationInfo']['created']}"
    if not re.fullmatch(r"https://[^#\s]+", document["documentNamespace"]):
        yield f"documentNamespace: {document['documentNamespace']}"
    ids = [document["SPDXID"], *(package["SPDXID"] for package in document["packages"])]
    yield from (f"{name} is not an identifier" for name in ids if not re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", name))
    yield from (f"{name} stands twice" for name in set(ids) if ids.count(name) > 1)
    for relation in document["relationships"]:
        for end in ("spdxElementId", "relatedSpdxElement"):
            if relation[end] not in ids:
                yield f"a relation names {relation[end]}, which is not listed"


def wrong_packages(document, debs):
    listed = {package["packageFileName"]: package["checksums"] for package in document["packages"]
              if "packageFileName" in package}
    actual = {deb.name: [{"algorithm": "SHA256", "checksumValue": hashlib.sha256(deb.read_bytes()).hexdigest()}]
              for deb in debs}
    yield from (f"{name} is listed as {listed.get(name)}, and is {actual.get(name)}"
                for name in sorted(listed.keys() | actual.keys()) if listed.get(name) != actual.get(name))


def main():
    document = json.loads(pathlib.Path(sys.argv[1]).read_text())
    debs = [pathlib.Path(name) for name in sys.argv[2:]]
    problems = list(missing_fields(document))
    if not problems:
        problems = [*wrong_values(document), *wrong_packages(document, debs)]
        names = {package["SPDXID"]: package["name"] for package in document["packages"]}
        relations = {(names.get(relation["spdxElementId"]), relation["relationshipType"],
                      names.get(relation["relatedSpdxElement"])) for relation in document["relationships"]}
        problems += [f"missing: {' '.join(words)}" for words in sorted(EXPECTED - relations)]
    if problems:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
