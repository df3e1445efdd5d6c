#!/usr/bin/env python3
"""Builds the API documentation with FORD, and says what is public and has no docstring.

    tools/api_docs.py [DIR]    DIR: where to put it, build/api when absent; status 1 after any warning

Run it with a Python that has FORD (`make docs` does). FORD's own option to warn of what is undocumented
knows no difference between a public procedure and the loop index inside; here only what it shows counts:

- modules, and their public types, components, type-bound procedures, procedures, interfaces, constants;
- the arguments of public procedures that are numbers, logicals, texts or procedures.

Not asked for: `self`, `error` and, in F77, `istat` and `msg`, which mean the same everywhere; arguments
of a derived type, which is documented itself; those of the C interface, which the headers of include/
documents; a type-bound procedure that overrides a documented one. Every other warning of FORD (a key it
does not know, an entity it cannot find) counts as well.
"""
import pathlib
import sys

import ford
import ford.fortran_project
import ford.sourceform

ROOT = pathlib.Path(__file__).resolve().parent.parent
CONVENTIONS = {"self", "error", "istat", "msg"}
DERIVED = {"type", "class"}


class Documentation:
    """One run of FORD: its warnings, and the undocumented items among what it shows."""

    def __init__(self, output_dir):
        self.warnings = []
        self.seen = set()
        self.project = None
        self.listen()
        sys.argv = ["ford", "--output_dir", str(output_dir), str(ROOT / "docs" / "ford.md")]
        settings, text = ford.initialize()
        ford.main(settings, text)
        for module in self.project.modules:
            self.look_at_module(module)
        for procedure in self.project.procedures:
            if not isinstance(procedure.parent, ford.sourceform.FortranModule):
                self.look_at_procedure(procedure)

    def listen(self):
        """Takes FORD's warnings, and the project that it builds."""
        for module in list(sys.modules.values()):
            if getattr(module, "__name__", "").startswith("ford") and hasattr(module, "warn"):
                module.warn = self.warnings.append
        documentation = self

        class Project(ford.fortran_project.Project):
            def __init__(self, *arguments):
                super().__init__(*arguments)
                documentation.project = self

        ford.fortran_project.Project = Project

    def require(self, item, what):
        """Notes an item without a docstring, once."""
        if id(item) in self.seen:
            return
        self.seen.add(id(item))
        if not "".join(item.doc_list).strip():
            self.warnings.append(f"{item.filename}: {what} has no docstring")

    def look_at_module(self, module):
        self.require(module, f"module {module.name}")
        for constant in module.variables:
            self.require(constant, f"constant {constant.name}")
        for derived_type in module.types:
            self.look_at_type(derived_type)
        for interface in module.interfaces + module.absinterfaces:
            if getattr(interface, "procedure", None):
                self.look_at_procedure(interface.procedure)
            else:
                self.require(interface, f"interface {interface.name}")
        for procedure in module.functions + module.subroutines:
            self.look_at_procedure(procedure)

    def look_at_type(self, derived_type):
        name = derived_type.name
        self.require(derived_type, f"type {name}")
        for component in derived_type.variables:
            self.require(component, f"component {name}%{component.name}")
        for bound in derived_type.boundprocs:
            if overrides(bound, derived_type):
                continue
            self.require(bound, f"type-bound procedure {name}%{bound.name}")
            for target in bound.bindings:
                procedure = getattr(target, "procedure", target)
                if isinstance(procedure, ford.sourceform.FortranProcedure):
                    self.look_at_arguments(procedure)

    def look_at_procedure(self, procedure):
        self.require(procedure, f"procedure {procedure.name}")
        self.look_at_arguments(procedure)

    def look_at_arguments(self, procedure):
        if procedure.bindC:
            return
        for argument in procedure.args:
            if argument.name.lower() not in CONVENTIONS and \
                    getattr(argument, "vartype", "procedure").lower() not in DERIVED:
                self.require(argument, f"argument {argument.name} of {procedure.name}")


def overrides(bound, derived_type):
    """Whether a type that this one extends has a type-bound procedure of that name."""
    parent = derived_type.extends
    while isinstance(parent, ford.sourceform.FortranType):
        if any(other.name.lower() == bound.name.lower() for other in parent.boundprocs):
            return True
        parent = parent.extends
    return False


def main():
    output_dir = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT / "build" / "api"
    documentation = Documentation(output_dir)
    for warning in sorted(set(documentation.warnings)):
        print(warning)
    print(f"{len(documentation.seen)} public items, {len(set(documentation.warnings))} warnings")
    return 1 if documentation.warnings else 0


if __name__ == "__main__":
    sys.exit(main())
