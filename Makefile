# Every target sets up what it needs first. `make help` lists them.
SHELL := /bin/bash
PRESET ?= release
JOBS ?= $(shell nproc 2>/dev/null || echo 2)
STICTION := build/release/stiction

.PHONY: help setup build install wheel experiments learners demo demo-touch test bench docs check-all release release-check format lock clean

help:
	@echo "make setup      system packages (when root), the Python environment .venv"
	@echo "make build      Release build; the program is $(STICTION)    (PRESET=dev|asan-ubsan|tsan for the others)"
	@echo "make install    the program, its data, the module and the library into PREFIX=…"
	@echo "make wheel      dist/stiction-*.whl for pip (Python 3.11; 3.12 and later), and the source archive"
	@echo "make learners   PyTorch, JAX and Gymnasium into build/learners, and the tests of what needs them, optional"
	@echo "make experiments  Drake and meshes of an iiwa into .venv: what \`$(STICTION) reproduce\` compares with, optional"
	@echo "make demo       plan, check and draw an in-hand reorientation in demo-out/"
	@echo "make demo-touch  an arm feels its way past what it does not know, in demo-out/"
	@echo "make test       every test: C++, Python, documentation"
	@echo "make bench      this machine's figures beside the published ones"
	@echo "make docs       the documentation site in build/site, tutorials run on the way"
	@echo "make check-all  formatting, debug build and sanitizers"
	@echo "make release    the wheels in dist, tried in empty environments and beside other packages (network, root for one of them)"
	@echo "make release-check  wheel, source archive, site, README commands, tests, sanitizers"
	@echo "make format     clang-format over the C++ files"
	@echo "make lock       requirements*.in -> requirements*.lock"
	@echo "make clean      removes build, dist and demo-out; .venv stays"

setup:
	@scripts/setup.sh

build: setup
	@scripts/build.sh $(PRESET) $(JOBS)

install: setup
	@test -n "$(PREFIX)" || { echo "make install: got no PREFIX, expected PREFIX=/folder" >&2; exit 2; }
	@scripts/build.sh release $(JOBS)
	@cmake --install build/release --prefix "$(PREFIX)" >build/install.log
	@echo "install: $(PREFIX)/bin/stiction"

wheel: setup
	@scripts/wheel.sh dist

experiments: setup
	@scripts/extras.sh experiments
	@scripts/meshes.sh

learners: build
	@scripts/learners.sh

demo: setup
	@scripts/build.sh release $(JOBS) stiction_cli
	@scripts/demo.sh

demo-touch: setup
	@scripts/build.sh release $(JOBS) stiction_cli
	@scripts/demo_touch.sh

test: setup
	@scripts/build.sh release $(JOBS)
	@scripts/test.sh $(JOBS)

bench: setup
	@scripts/build.sh release $(JOBS) stiction_cli stiction_bench
	@$(STICTION) bench

docs: setup
	@scripts/extras.sh docs
	@scripts/build.sh release $(JOBS) stiction_cli stiction_package stiction_stub
	@scripts/docs.sh

check-all: setup
	@scripts/check_all.sh $(JOBS)

release: setup
	@scripts/release.sh

release-check: setup
	@scripts/release_check.sh $(JOBS)

format:
	@git ls-files -z '*.hpp' '*.cpp' | xargs -0 clang-format -i

lock:
	@scripts/lock.sh

clean:
	rm -rf build dist demo-out
