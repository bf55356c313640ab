# `make` lists the targets. Everything goes into .venv; PYTHON=python3.10 takes another interpreter.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
SOURCES := pyproject.toml CMakeLists.txt $(wildcard cmake/*) $(shell find cpp -name '*.?pp' -o -name CMakeLists.txt)
CXX_BUILD := build/cpp

.DEFAULT_GOAL := help
.PHONY: help demo test bench lint format sanitize clean

help: ## list the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## */  make \1|/' | column -t -s '|'

demo: $(VENV)/.edgefusion ## the main job on the scene that comes with the project (results in out/)
	@$(BIN)/edgefusion demo

test: $(VENV)/.test ## every fast test (pytest; ARGS="-k dbscan" picks some)
	@$(BIN)/python -m pytest $(ARGS)

bench: $(VENV)/.bench ## measure against the named peers and write out/bench/ (about ten minutes)
	@$(BIN)/python -m benchmarks.run $(ARGS)

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

clean: ## remove everything that was built, .venv too
	rm -rf build $(VENV)

# What is missing and cannot be installed here is said in one line by scripts/bootstrap.sh.
$(VENV)/bin/python:
	@PYTHON=$(PYTHON) VENV=$(VENV) scripts/bootstrap.sh

# Editable: a change in Python needs no new installation, one in C++ does.
$(VENV)/.edgefusion: $(SOURCES) | $(VENV)/bin/python
	@echo "edgefusion: building and installing into $(VENV) (about a minute) ..."
	@$(BIN)/python -m pip install -q -e '.[cpu]'
	@touch $@

$(VENV)/.test: $(VENV)/.edgefusion
	@echo "edgefusion: installing the tests' tools ..."
	@$(BIN)/python -m pip install -q $$($(BIN)/python scripts/extra.py test)
	@touch $@

$(VENV)/.bench: $(VENV)/.edgefusion
	@echo "edgefusion: installing the benchmarks' peers ..."
	@$(BIN)/python -m pip install -q $$($(BIN)/python scripts/extra.py bench)
	@touch $@

$(VENV)/.lint: $(VENV)/.edgefusion
	@echo "edgefusion: installing the linters ..."
	@$(BIN)/python -m pip install -q $$($(BIN)/python scripts/extra.py lint)
	@touch $@

$(VENV)/.cpp: pyproject.toml | $(VENV)/bin/python
	@$(BIN)/python -m pip install -q cmake ninja 'cmeel-eigen>=3.4,<3.5'
	@touch $@
