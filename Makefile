# SPDX-License-Identifier: Apache-2.0
# Everything a person or CI does here, by one word each. `make help` lists the words.
.DEFAULT_GOAL := help
.PHONY: help run test build setup quick nightly check format sanitize asan tsan fuzz mutants bench experiments pictures install package wheel clean

JOBS ?= $(shell nproc)
SECONDS ?= 60
PREFIX ?= /usr/local
export JOBS

help:  ## list these words
	@sed -nE 's/^([a-z]+):.*## (.*)/  make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 18

run:  ## set up, build what a first picture needs, and draw a sample volume to build/sample.png
	@scripts/run.sh

test: setup  ## set up, build, and run all tests
	@scripts/setup.sh test
	@scripts/build.sh release
	@scripts/run_tests.sh release

build: setup  ## set up and build the program, its readers and its window: build/release/bin/ovoid
	@scripts/build.sh release ovoid_program ovoid_reader ovoid_viewer

setup:  ## install the distribution's packages (nothing to do when they are there)
	@scripts/setup.sh program build

quick:  ## build and test the parts that changed since the last commit, or PART="io render/cpu"; minutes the first time
	@scripts/setup.sh program build test
	@python3 scripts/quick.py $(PART)

nightly:  ## all that takes longer than a commit's checks may, in parts (PART="asan tsan"); goes on where it was stopped
	@scripts/nightly.sh $(PART)

check: build  ## style, dependency direction, licences, clang-tidy
	@scripts/setup.sh check
	@scripts/check.sh

format: setup  ## clang-format all sources in place
	@scripts/setup.sh check
	@scripts/check_format.sh --fix

sanitize: asan tsan  ## the tests of what reads files, makes models and has threads, under sanitizers

asan tsan: setup
	@scripts/setup.sh test clang
	@scripts/build.sh $@ -DOVOID_SANITIZE_ALL=OFF tests_labelled_$@
	@scripts/run_tests.sh $@ -L $@

fuzz: setup  ## fuzz the readers for SECONDS (60) each
	@scripts/setup.sh clang
	@scripts/fuzz.sh $(SECONDS)

mutants: build  ## damage files a thousand times each, and let the program read them
	@scripts/build.sh release test_files
	@python3 tests/hostile/mutants.py build/release/bin/ovoid --count $(or $(COUNT),1000)

bench: build  ## measure against the peers; the table goes to bench/results/ (of DATA="...": BENCH=looks first pictures, BENCH=fit fewer kernels, BENCH=simplify runs and boxes, BENCH=mappers in VTK, BENCH=processes by several, BENCH=python from Python; BENCH=solids, BENCH=sites)
	@if [ -n "$(filter looks fit simplify solids processes,$(BENCH))" ]; then \
	  scripts/setup.sh bench && python3 bench/$(BENCH).py $(DATA); \
	elif [ "$(BENCH)" = mappers ]; then \
	  scripts/build.sh release ovoid_program ovoid_mappers && bench/vtk_mappers.sh $(DATA); \
	elif [ "$(BENCH)" = python ]; then \
	  scripts/setup.sh bench && scripts/build.sh release ovoid_program ovoid_package && \
	  LIBGL_ALWAYS_SOFTWARE=1 PYTHONPATH="$(CURDIR)/build/release/python" xvfb-run --auto-servernum /usr/bin/python3 bench/python.py $(DATA); \
	elif [ "$(BENCH)" = sites ]; then \
	  scripts/build.sh release ovoid_experiments && build/release/bin/ovoid_experiments build sites; \
	else \
	  scripts/setup.sh bench && scripts/build.sh bench && python3 bench/run.py $(BENCH) && python3 bench/convergence.py; \
	fi

experiments: setup  ## the tables and pictures of docs/numerics.md, measured again
	@scripts/build.sh release ovoid_experiments
	@mkdir -p docs/images
	@build/release/bin/ovoid_experiments docs/images

pictures: build  ## draw the pictures of the guide and the other pages again, by their own commands and scripts
	@scripts/run_docs.py build/release/bin/ovoid docs/guide.md docs/annotations.md docs/time.md docs/solids.md docs/geometry.md \
	  docs/labels.md docs/two-volumes.md docs/looks2d.md docs/pictures.md
	@scripts/viewer_pictures.sh

install: build  ## install program, library and headers under PREFIX (/usr/local)
	@scripts/build.sh release ovoid_mappers ovoid_team ovoid_package
	@cmake --install build/release --prefix "$(PREFIX)"

package: build  ## a .deb of program, window, library and headers, and one of the Python package: build/package/*.deb
	@scripts/build.sh release ovoid_team ovoid_package
	@cpack --config build/release/CPackConfig.cmake -B "$(CURDIR)/build/package" >/dev/null
	@ls build/package/*.deb

wheel: setup  ## a wheel of the Python package, with the libraries it needs: build/package/ovoid-*.whl
	@scripts/build.sh release ovoid_package
	@/usr/bin/python3 python/wheel/check.py "$$(/usr/bin/python3 python/wheel/back_end.py --portable --build-dir build/release build/package)"

clean:  ## remove everything that was built
	rm -rf build
