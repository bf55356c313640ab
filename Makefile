# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
# `make` lists the targets. Everything goes into .venv; PYTHON=python3.10 takes another interpreter.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
SOURCES := pyproject.toml CMakeLists.txt $(wildcard cmake/*) $(shell find cpp -name '*.?pp' -o -name CMakeLists.txt)
CXX_BUILD := build/cpp

.DEFAULT_GOAL := help
.PHONY: help demo test bench bench-core fuzz faults soak end-to-end lateness lint format sanitize clean

help: ## list the targets
	@awk -F ':.*## *' '/^[a-z-]+:.*##/ { printf "  make %-11s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

demo: $(VENV)/.edgefusion ## a simulated robot drives to a goal and inspects what is on the way; a report below out/
	@$(BIN)/edgefusion demo $(ARGS)

test: $(VENV)/.test ## every fast test (pytest; ARGS="-k dbscan" picks some)
	@$(BIN)/python -m pytest $(ARGS)

bench: $(VENV)/.bench ## measure against the named peers and write out/bench/ (about five minutes)
	@$(BIN)/python -m benchmarks.run $(ARGS)

bench-core: $(VENV)/.cpp ## the C++ core alone, without Python (Google Benchmark)
	@VENV=$(VENV) scripts/cpp_bench.sh $(CXX_BUILD)-release $(ARGS)

faults: $(VENV)/.bench ## inject faults from the laser to the disk and time what happens, in real time (an hour; ARGS="--only L")
	@$(BIN)/python -m benchmarks.faults $(ARGS)

end-to-end: $(VENV)/.bench ## the experiment with all processes and a laptop, in real time: drive, latency, memory (two minutes)
	@$(BIN)/python -m benchmarks.end_to_end $(ARGS)

lateness: $(VENV)/.bench ## how late the base is while vision fills all processors (three minutes)
	@$(BIN)/python -m benchmarks.lateness $(ARGS)

fuzz: $(VENV)/.edgefusion ## the readers of both wire protocols on streams that no device sends (MINUTES=10)
	@$(BIN)/python -m benchmarks.fuzz --minutes $(or $(MINUTES),10) $(ARGS)

soak: $(VENV)/.bench ## drive on while something goes wrong every minute: memory, stops, contacts (MINUTES=30)
	@$(BIN)/python -m benchmarks.soak --minutes $(or $(MINUTES),30) $(ARGS)

lint: $(VENV)/.lint ## ruff, clang-format and mypy
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@find cpp -name '*.?pp' | xargs $(BIN)/clang-format --dry-run --Werror
	@$(BIN)/mypy

format: $(VENV)/.lint ## let ruff and clang-format rewrite what they can
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .
	@find cpp -name '*.?pp' | xargs $(BIN)/clang-format -i

sanitize: $(VENV)/.cpp ## the C++ tests under AddressSanitizer + UBSan, then under ThreadSanitizer
	@VENV=$(VENV) scripts/cpp_tests.sh $(CXX_BUILD)-address address,undefined
	@VENV=$(VENV) scripts/cpp_tests.sh $(CXX_BUILD)-thread thread

clean: ## remove what was built and installed, not the results in out/
	rm -rf build $(VENV) .venv-tx2

# What is missing and cannot be installed here is said in one line by scripts/bootstrap.sh.
$(VENV)/.created:
	@PYTHON=$(PYTHON) VENV=$(VENV) scripts/bootstrap.sh
	@touch $@

# Editable: a change in Python needs no new installation, one in C++ does.
$(VENV)/.edgefusion: $(SOURCES) | $(VENV)/.created
	@echo "edgefusion: building and installing into $(VENV) (about a minute) ..."
	@$(BIN)/python -m pip install -q -e '.[cpu,sim]'
	@touch $@

$(VENV)/.test: $(VENV)/.edgefusion
	@echo "edgefusion: installing the tests' tools ..."
	@$(BIN)/python -m pip install -q $$($(BIN)/python scripts/requirements.py test)
	@touch $@

$(VENV)/.bench: $(VENV)/.edgefusion
	@echo "edgefusion: installing the benchmarks' peers ..."
	@$(BIN)/python -m pip install -q $$($(BIN)/python scripts/requirements.py bench)
	@touch $@

$(VENV)/.lint: $(VENV)/.edgefusion
	@echo "edgefusion: installing the linters ..."
	@$(BIN)/python -m pip install -q $$($(BIN)/python scripts/requirements.py lint)
	@touch $@

$(VENV)/.cpp: pyproject.toml | $(VENV)/.created
	@$(BIN)/python -m pip install -q cmake ninja $$($(BIN)/python scripts/requirements.py eigen)
	@touch $@
