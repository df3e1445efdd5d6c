#!/usr/bin/env python3
"""Turns the tables of data/ into Fortran modules.

    tools/embed_tables.py            writes the modules that are out of date
    tools/embed_tables.py --check    writes nothing; status 1 when one is out of date or left over
"""
import importlib.util
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def generated():
    sys.path.insert(0, str(ROOT / "tools"))
    for path in sorted((ROOT / "tools" / "embed").glob("*.py")):
        spec = importlib.util.spec_from_file_location(path.stem, path)
        generator = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(generator)
        for module, text in generator.generate(ROOT / "data").items():
            _, floor, room = module.split("_", 2)
            yield ROOT / ("app" if floor == "cli" else "src") / floor / "tables" / f"{room}.f90", text


def main():
    check = "--check" in sys.argv[1:]
    stale, written = [], set()
    for path, text in generated():
        written.add(path)
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(path)
        if not check:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    left_over = [p for top in ("src", "app") for p in (ROOT / top).rglob("tables/table_*.f90") if p not in written]
    for path in stale:
        print(("out of date: " if check else "written: ") + str(path.relative_to(ROOT)))
    for path in left_over:
        print("without a generator: " + str(path.relative_to(ROOT)))
    return 1 if check and stale + left_over else 0


if __name__ == "__main__":
    sys.exit(main())
