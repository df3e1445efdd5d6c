# The project's commands, for GNU make. tools/setup.sh installs what is missing and prints the fpm to use.
#
# Everything else is fpm's: fpm build, fpm run -- --help, fpm test -- SUITE.

# What `make run` runs: the estimates of the report's six cases, and its Tables 6.1 and 6.2.
MAIN_JOB = montecarlo

.DEFAULT_GOAL := help
.PHONY: help run test build report claims docs dist install uninstall clean
# All targets share fpm's build tree.
.NOTPARALLEL:

help:
	@echo 'make run     the main job: gracecg $(MAIN_JOB)'
	@echo '             another: make run MAIN_JOB="--help"'
	@echo 'make test    all tests'
	@echo 'make build   the release program, at build/bin/gracecg'
	@echo 'make report  the pages of everything that CSR-TM-00-01 shows, at report/index.html (minutes)'
	@echo 'make install PREFIX=/usr/local'
	@echo '             program, manual page, static and shared library, modules, C header, pkg-config file'
	@echo '             (also DESTDIR, BINDIR, LIBDIR, INCLUDEDIR, MANDIR; make uninstall removes them)'
	@echo 'make claims  runs the commands and examples that print the numbers of the documents, and lists what differs'
	@echo '             (minutes; long studies, too: tools/check_claims.py --all)'
	@echo 'make docs    the documentation of all modules, at build/api/index.html'
	@echo 'make dist    the sources as committed, build/gracecg-VERSION.tar.gz: they build without a network'
	@echo 'make clean   removes what was built (what was installed from PyPI stays in .venv)'
	@echo
	@echo 'run, test, build and install compile for the processor of this machine; PORTABLE=1 turns it off, for packages:'
	@echo '             the shared library is then installed for newer processors, too, where the loader finds it'
	@echo
	@echo 'All of them first install what this machine lacks to do their work (tools/setup.sh).'

# fpm with the flags for this machine, and for each file (tools/compiler). Each set of flags has a build tree of its own.
READY = fpm="$$(tools/setup.sh)" && tools/commit.sh build/commit && export FPM_FFLAGS="$$(tools/flags.sh)" \
	FPM_FC="$${FPM_FC:-$$PWD/tools/compiler/gfortran}"
FPM = $(READY) && "$$fpm"

# fpm does not link a program anew when another of its commands has rebuilt the library since: the
# programs are removed first.
run:
	@rm -f build/gfortran_*/app/gracecg
	@$(FPM) run --profile release -- $(MAIN_JOB)

test:
	@rm -f build/gfortran_*/test/tester
	@$(FPM) test --profile release

build:
	@rm -f build/gfortran_*/app/gracecg
	@$(FPM) build --profile release && \
		"$$fpm" install --profile release --prefix build/stage >/dev/null && \
		install -D build/stage/bin/gracecg build/bin/gracecg

# What pages take is set up, too.
report: build
	@tools/setup.sh pages >/dev/null && build/bin/gracecg report --out report

claims: build
	@tools/setup.sh pages >/dev/null && export GRACECG_PYTHON="$$PWD/.venv/bin/python" && \
		if python3 tools/check_claims.py; then python3 tools/check_examples.py; else python3 tools/check_examples.py; false; fi

docs:
	@python="$$(tools/setup.sh ford)" && "$$python" tools/api_docs.py

# The version is that of fpm.toml.
dist:
	@mkdir -p build && name="gracecg-$$(sed -n 's/^version = "\(.*\)"$$/\1/p' fpm.toml)" && \
		git archive --format=tar.gz --prefix="$$name/" -o "build/$$name.tar.gz" HEAD && echo "build/$$name.tar.gz"

export PREFIX BINDIR LIBDIR INCLUDEDIR MANDIR DESTDIR

install:
	@tools/install.sh

uninstall:
	@tools/install.sh --remove

clean:
	rm -rf build
