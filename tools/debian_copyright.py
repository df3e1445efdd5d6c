#!/usr/bin/env python3
"""Writes debian/copyright, in Debian's machine-readable form (DEP 5), of REUSE.toml, LICENSES/ and data/README.md.

    tools/debian_copyright.py            writes it; tools/check_metadata.py finds one that is out of date
"""
import pathlib
import re
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
DEBIAN = {"MIT": "Expat"}       # what Debian calls a licence of SPDX
HEAD = """Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: gracecg
Comment: Written by tools/debian_copyright.py. data/README.md, installed as DATA.md, has the source of every table of figures
 and what is known of the rights in it.
 ."""


def paragraph(text):
    """Lines of a text that belongs to a field."""
    return "\n".join(" " + (line.rstrip() or ".") for line in text.strip().splitlines())


def attribution(root):
    """Who must be named, as data/README.md says."""
    text = (root / "data/README.md").read_text(encoding="utf-8")
    return re.search(r"^## Attribution\n(.*?)^## ", text, flags=re.M | re.S).group(1)


def copyright_text(root):
    """The file: the last paragraph that fits a file holds, in REUSE.toml as here."""
    annotations = tomllib.loads((root / "REUSE.toml").read_text(encoding="utf-8"))["annotations"]
    parts, used = [HEAD + "\n" + paragraph(attribution(root))], []
    for annotation in annotations:
        paths, holders = ([value] if isinstance(value, str) else value
                          for value in (annotation["path"], annotation["SPDX-FileCopyrightText"]))
        names = annotation["SPDX-License-Identifier"].split(" AND ")
        used += [name for name in names if name not in used]
        parts.append("Files: " + "\n       ".join(path.replace("**", "*") for path in paths) +
                     "\nCopyright: " + "\n           ".join(holders) +
                     "\nLicense: " + " and ".join(DEBIAN.get(name, name) for name in names))
    for name in used:
        text = (root / f"LICENSES/{name}.txt").read_text(encoding="utf-8")
        parts.append(f"License: {DEBIAN.get(name, name)}\n{paragraph(text)}")
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    sys.exit((ROOT / "debian/copyright").write_text(copyright_text(ROOT), encoding="utf-8") and None)
