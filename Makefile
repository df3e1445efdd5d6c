# The project's commands, for GNU make. tools/setup.sh installs what is missing and prints the fpm to use.
#
# Everything else is fpm's: fpm build, fpm run -- --help, fpm test -- SUITE.

# What `make run` runs: the estimates of the report's six cases, and its Tables 6.1 and 6.2.
MAIN_JOB = montecarlo

.DEFAULT_GOAL := help
.PHONY: help run test build clean
# All targets share fpm's build tree.
.NOTPARALLEL:

help:
	@echo 'make run     the main job: gracecg $(MAIN_JOB)'
	@echo '             another: make run MAIN_JOB="--help"'
	@echo 'make test    all tests'
	@echo 'make build   the release program, at build/bin/gracecg'
	@echo 'make clean   removes what was built (an fpm that was installed stays in .venv)'
	@echo
	@echo 'run, test and build first install what this machine lacks (tools/setup.sh).'

# fpm does not link a program anew when another of its commands has rebuilt the library since: the
# programs are removed first.
run:
	@rm -f build/gfortran_*/app/gracecg
	@fpm="$$(tools/setup.sh)" && "$$fpm" run --profile release -- $(MAIN_JOB)

test:
	@rm -f build/gfortran_*/test/tester
	@fpm="$$(tools/setup.sh)" && "$$fpm" test --profile release

build:
	@rm -f build/gfortran_*/app/gracecg
	@fpm="$$(tools/setup.sh)" && "$$fpm" install --profile release --prefix build --bindir bin

clean:
	rm -rf build
