# Everything runs in .venv, made on demand; bare `make` explains the targets.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin
STAMP := .venv/.installed
PACKAGES := bus robot_model estimation robot_sim services dashboard deploy experiments
SOURCES := $(PACKAGES) tests benchmarks
ARGS ?=

.DEFAULT_GOAL := help
.PHONY: help demo test check bench clean compile chromium

help:  ## show this list
	@echo "Wrenchbus: make TARGET [ARGS='...']"
	@sed -n 's/^\([a-z]*\):.*## /  \1@/p' $(MAKEFILE_LIST) | awk -F@ '{printf "%-9s %s\n", $$1, $$2}'

demo: compile  ## start the robot and its services, open the page (ARGS='--seconds 60 --no-browser')
	@$(BIN)/wrenchbus demo $(ARGS)

test: compile chromium  ## run every test (ARGS='tests/bus -x')
	@scripts/test.sh $(BIN)/python $(ARGS)

check: compile  ## lint, format, types, import rules
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/pyright
	$(BIN)/lint-imports

bench: compile  ## measure beside peers, write docs/performance.md (ARGS='--quick', ARGS='--only bus')
	$(BIN)/python -m benchmarks $(ARGS)

clean:  ## remove the environment and everything generated
	rm -rf .venv build *.egg-info .hypothesis .benchmarks .ruff_cache .import_linter_cache
	find $(SOURCES) -name __pycache__ -type d -prune -exec rm -rf {} +

# Byte code is written here, because some environments forbid it at import and then
# every start of the demo would compile everything again (4 s instead of 1 s).
compile: $(STAMP)
	@$(BIN)/python -m compileall -q $(PACKAGES)

chromium: $(STAMP)
	@scripts/chromium.sh

$(STAMP): pyproject.toml constraints.txt
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed: install python3.11"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Python 3.11 or newer is needed, $(PYTHON) is older: make PYTHON=/path/to/python3.11"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv || \
		{ echo "python3 -m venv failed: on Debian and Ubuntu, apt install python3-venv"; rm -rf .venv; exit 1; }
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt setuptools
	$(BIN)/python -m pip install -q --disable-pip-version-check --no-compile -c constraints.txt \
		--no-build-isolation -e ".[test]"
	-@$(BIN)/python -m compileall -q -j 0 .venv/lib >/dev/null
	-@$(BIN)/python -m robot_model.surface icub >/dev/null  # cached, so that no first start waits
	@touch $@
