#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a list of the contents of packages (SPDX 2.3, JSON) next to them.

  list_contents.py BUILD LOCK DEB...

BUILD is the build directory from which the packages were made, LOCK the package-lock.json of the page.
Each package is listed with its checksum, and with the libraries that its programs use, according to the
build. A system library whose headers were compiled in counts as linked dynamically if a shared library
of the same source package was linked, otherwise as contained in the program. SOURCE_DATE_EPOCH is the
date.
"""
import base64
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys

# The parts of the compiler and the C library that are in every program.
TOOLCHAIN = re.compile(r"(libc6|linux-libc|libgcc-.*|libstdc\+\+-.*)-dev")


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def depended_on(build):
    """Return the files that the compiler read for each object."""
    files, of_object = {}, None
    for line in output("ninja", "-C", build, "-t", "deps").splitlines():
        if line.startswith("    "):
            of_object.append(line.strip())
        elif ": #deps" in line:
            of_object = files.setdefault(line.split(": #deps")[0], [])
    return files


def targets_of(deb, targets):
    """Return the programs and libraries of the build that are files of a package."""
    names = {line.rsplit("/", 1)[-1] for line in output("dpkg-deb", "--contents", deb).splitlines()}
    return [target for target in targets if target.rsplit("/", 1)[-1] in names]


def owners(files):
    """Return (binary package, source package, version) for each file of the system that has an owner."""
    files = sorted({os.path.realpath(file) for file in files})
    found = subprocess.run(["dpkg-query", "--search", *files], capture_output=True, text=True).stdout
    rows = output("dpkg-query", "--show",
                  "--showformat=${binary:Package} ${Package} ${source:Package} ${Version}\n")
    known = {}
    for row in rows.splitlines():
        name, *owner = row.split()
        known[name] = known[owner[0]] = tuple(owner)
    rows = (line.split(": ", 1) for line in found.splitlines() if not line.startswith("diversion by "))
    return {path: known[names.split(", ")[0]] for names, path in rows}


def identifier(*words):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", "-".join(words))


def package(name, version, url, *, licence="NOASSERTION", place="NOASSERTION", **more):
    return {"SPDXID": identifier("Package", name, version), "name": name, "versionInfo": version,
            "downloadLocation": place, "filesAnalyzed": False, "licenseConcluded": licence,
            "licenseDeclared": licence, "copyrightText": "NOASSERTION",
            "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                              "referenceLocator": url}], **more}


def packages_of_page(build, lock):
    """Return the packages that the page of the gateway bundles, if this build has a page."""
    if not any(build.glob("clients/gateway/**/dist/index.html")):
        return []
    locked = json.loads(lock.read_text())["packages"]
    rows = []
    for path, entry in sorted(locked.items()):
        if not path or entry.get("dev"):
            continue  # the page itself, and what only builds it
        name = path.removeprefix("node_modules/")
        algorithm, digest = entry["integrity"].split("-", 1)
        rows.append(package(
            name, entry["version"], f"pkg:npm/{name.replace('@', '%40')}@{entry['version']}", licence=entry["license"],
            checksums=[{"algorithm": algorithm.upper(),
                        "checksumValue": base64.b64decode(digest).hex()}]))
    return rows


def main():
    build, lock, *debs = map(pathlib.Path, sys.argv[1:])
    of_objects = depended_on(build)
    targets = [line.split(": ")[0] for line in output("ninja", "-C", build, "-t", "targets", "all").splitlines()
               if not line.endswith(": phony")]
    inputs = {}  # by package: the system files that were compiled in or linked
    for deb in debs:
        files = set()
        for target in targets_of(deb, targets):
            for file in output("ninja", "-C", build, "-t", "inputs", target).splitlines():
                files.update([file] if file.startswith("/usr/lib/") else of_objects.get(file, []))
        inputs[deb] = {file for file in files if file.startswith("/usr/")}
    owner_of = owners(set().union(*inputs.values()))

    distribution = "debian-" + output("sh", "-c", '. /etc/os-release; echo "$VERSION_ID"').strip()
    packages, relations = {}, []

    def relate(first, kind, second):
        relations.append({"spdxElementId": first, "relationshipType": kind, "relatedSpdxElement": second})

    for deb in sorted(debs):
        name, version, architecture = output(
            "dpkg-deb", "--show", "--showformat=${Package} ${Version} ${Architecture}", deb).split()
        ours = package(name, version, f"pkg:deb/vdrive/{name}@{version}?arch={architecture}&distro={distribution}",
                       licence="Apache-2.0", packageFileName=deb.name, supplier="Organization: vdrive maintainers",
                       checksums=[{"algorithm": "SHA256",
                                   "checksumValue": hashlib.sha256(deb.read_bytes()).hexdigest()}])
        packages[ours["SPDXID"]] = ours
        relate("SPDXRef-DOCUMENT", "DESCRIBES", ours["SPDXID"])
        used = {owner_of[os.path.realpath(file)]: file for file in sorted(inputs[deb])
                if os.path.realpath(file) in owner_of}
        shared = {source for (_, source, _), file in used.items() if ".so" in pathlib.Path(file).name}
        for library, source, its_version in sorted(used):
            # Only -dev packages are listed: the runtime package of a dynamically linked library is already in Depends.
            if TOOLCHAIN.fullmatch(library) or not library.endswith("-dev"):
                continue
            row = package(library, its_version, f"pkg:deb/debian/{library}@{its_version}?distro={distribution}")
            packages[row["SPDXID"]] = row
            relate(ours["SPDXID"], "DYNAMIC_LINK" if source in shared else "STATIC_LINK", row["SPDXID"])
        if name == "vdrive-gateway":
            for row in packages_of_page(build, lock):
                packages[row["SPDXID"]] = row
                relate(ours["SPDXID"], "CONTAINS", row["SPDXID"])

    sums = "".join(row["checksums"][0]["checksumValue"] for row in packages.values() if "checksums" in row)
    title = f"vdrive_{version}_{output('dpkg', '--print-architecture').strip()}"
    created = datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc)
    document = {
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": title,
        "documentNamespace": f"https://spdx.org/spdxdocs/{title}-{hashlib.sha256(sums.encode()).hexdigest()}",
        "creationInfo": {"created": created.strftime("%Y-%m-%dT%H:%M:%SZ"),
                         "creators": ["Organization: vdrive maintainers", "Tool: deploy/list_contents.py"]},
        "packages": list(packages.values()), "relationships": relations}
    debs[0].with_name(f"{title}.spdx.json").write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
