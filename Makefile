# `make demo` and `make test` set up what they need from Python 3.11 or newer and the package registry.
PYTHON ?= $(shell for p in python3.13 python3.12 python3.11 python3; do \
  command -v $$p >/dev/null 2>&1 && $$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
BIN := .venv/bin
DEMO := .venv/.demo
READY := .venv/.ready
COMPILED := .venv/.compiled
KERNEL := .venv/.kernel
# What a certificate's search runs; numba compiles it at its first use, which takes as long as a whole proof.
SEARCH := $(wildcard deploy/theory/certify/*.py)

, := ,
# The machine's uv, else the one in .venv.
UV = $(shell uv --version >/dev/null 2>&1 && echo uv || echo $(BIN)/uv)
# $(call install,EXTRAS,OPTIONS): this checkout and these extras in .venv, by uv where the registry has it for this machine, else by pip.
define install
@test -n "$(PYTHON)" || { echo "disknav needs Python 3.11 or newer; none was found"; exit 1; }
@test -x $(BIN)/python || $(PYTHON) -m venv .venv
@$(UV) --version >/dev/null 2>&1 || $(BIN)/python -m pip install --quiet --disable-pip-version-check uv 2>/dev/null || true
@export HATCH_BUILD_NO_HOOKS=true; if $(UV) --version >/dev/null 2>&1; \
  then $(UV) pip install --quiet --python $(BIN)/python --editable '.[$(1)]' $(2); \
  else $(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[$(1)]' $(2); fi
@touch $@
endef

.DEFAULT_GOAL := help
.PHONY: help setup lock compile sources site demo test fast check collect campaigns golden bench fuzz proof figures diagrams engines clean

help:  ## say what there is
	@awk -F':.*## ' '/^[a-z]+:.*## / {printf "  make %-9s %s\n", $$1, $$2}' Makefile

demo: $(if $(wildcard $(READY)),$(READY),$(DEMO))  ## six real processes drive the paper's figure 1; leaves out/figure-1.mcap and .png
	@mkdir -p out
	$(BIN)/disknav run figure-1 --record out/figure-1.mcap --plot out/figure-1.png
	@echo; echo "Next: look at out/figure-1.png; see the run again on a live page, and what the theory says of six robots:"; \
	  echo "  $(BIN)/disknav recording replay out/figure-1.mcap --web"; echo "  $(BIN)/disknav check swap-6"; \
	  echo "\`make setup\` installs all extras and compiles; docs/index.md goes on from here."

setup:  ## build .venv with everything that running and testing needs, and compile
	@$(MAKE) --no-print-directory --jobs=2 $(COMPILED) $(KERNEL)

lock: $(READY)  ## renew the versions that `make setup` and `make test` install
	$(UV) pip compile --quiet --upgrade --universal --python-version 3.11 --extra all --extra test \
	  --no-header --no-annotate --no-emit-index-url pyproject.toml -o requirements.lock

compile: $(COMPILED)  ## make C again of the modules that run for every message, and test it as their sources are tested; three minutes
	$(BIN)/python -m pytest -n auto -m 'not slow and not process and not alone and not campaign' tests/agents tests/protocol tests/world
	$(BIN)/python -m pytest -m 'not process and not campaign' tests/deploy/test_software.py tests/deploy/calibrate tests/benchmarks tests/system/orders/test_scheduled_orders.py

$(DEMO): pyproject.toml
	$(call install,demo)

$(READY): pyproject.toml requirements.lock
	$(call install,all$(,)test,--constraint requirements.lock)

$(COMPILED): $(READY) compile.py $(shell find protocol agents world -name '*.py')
	@mkdir -p build; find . -name '*__mypyc*.so' -not -path './.venv/*' -delete
	@if $(BIN)/python compile.py >build/compile.log 2>&1; then echo "compiled"; \
	  find protocol agents world deploy -name '*.so' -exec touch {} +; \
	else tail -1 build/compile.log | cut -c 1-200; find protocol agents world deploy -name '*.so' -delete; \
	  echo "not compiled (is there a C compiler, are there Python's headers?): a robot's step takes about five times as long; to try again: touch compile.py"; fi
	@touch $@

$(KERNEL): $(READY) $(SEARCH)
	@mkdir -p build; rm -f build/figure-2.certificate.json
	@$(BIN)/python -m disknav certify figure-2 --k 1000 --quiet --out build/figure-2.certificate.json >/dev/null
	@touch $@

check: $(READY)  ## lint, formatting, types, import contracts
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

fast test collect: export PYTHONDONTWRITEBYTECODE =  # hundreds of interpreters: else each compiles its modules itself

collect: $(READY)  # once: else each process of pytest-xdist rewrites what all tests assert
	@mkdir -p build; $(BIN)/python -m pytest --collect-only -qqq >build/collected.log || { cat build/collected.log; exit 1; }

fast: $(READY)  ## the part of the suite that takes a minute
	$(BIN)/python -m pytest -n auto -m 'not slow and not process and not browser and not alone and not campaign'

sources:  ## remove what was compiled, so that the sources run
	@find protocol agents world deploy -name '*.so' -print -delete | grep . >/dev/null && \
	  echo "removed what was compiled: the sources run until \`make setup\`"; rm -f *__mypyc*.so $(COMPILED)

test: $(READY) sources  ## lint, types, import contracts, and the whole suite from the sources; five to eight minutes
	@$(MAKE) --no-print-directory --jobs=2 $(KERNEL) check collect
	$(BIN)/python -m pytest -n 3 --dist worksteal --durations=20 -m 'not alone and not campaign'  # many wait for real time
	$(BIN)/python -m pytest --durations=5 -m 'alone and not campaign' $$(grep -rl --include='test_*.py' 'mark\.alone' tests)

campaigns: $(READY) sources  ## what the suite leaves out: long runs, a thousand examples of each property, planted faults and mutants
	$(BIN)/python -m pytest -n 2 -m 'campaign and not alone'
	$(BIN)/python -m pytest -m 'campaign and alone' $$(grep -rl --include='test_*.py' 'mark\.alone' tests)
	$(BIN)/python -m pytest -n 2 -m 'hypothesis and not campaign' --hypothesis-profile campaign

golden: $(READY) $(COMPILED)  ## renew the kept trajectories of the library, and say by how much each has changed
	$(BIN)/python -m tests.golden

bench: $(READY) $(COMPILED)  ## rates and costs, as ratios against floors measured in the same run
	$(BIN)/python -m tests.benchmarks

fuzz: $(READY) $(COMPILED)  ## a million damaged inputs for everything that reads what strangers wrote; some minutes
	$(BIN)/python -m tests.campaigns fuzz

proof: $(READY)  ## prove the safety kernel with two solvers, and refute it without each of its rules; some minutes
	$(BIN)/python -m tests.proof --cvc5
	$(BIN)/python -m tests.proof --mutants

figures: $(READY) $(COMPILED)  ## run all studies; tables, data and pictures in out/; half an hour, goes on after Ctrl-C
	@mkdir -p out
	$(BIN)/disknav run figure-1 --plot docs/pictures/figure-1.png
	$(BIN)/disknav run figure-2 --record out/figure-2.mcap
	$(BIN)/disknav recording plot out/figure-2.mcap --until 2.5 -o docs/pictures/figure-2.png
	$(BIN)/disknav check figure-2 > out/figure-2.txt
	$(BIN)/python -m tests.benchmarks.theory.sampled > out/sampled.md
	$(BIN)/python -m tests.benchmarks.theory.certified --write
	for study in tightness tuning robustness arrival delay scale; do \
	  $(BIN)/disknav study $$study --json out/$$study.json || exit $$?; done
	$(BIN)/disknav study peers --runs 3 --json out/peers.json
	$(BIN)/python docs/examples/01-figures/draw.py out/tightness.json tight nrl_mean
	$(BIN)/python docs/examples/01-figures/draw.py out/tuning.json k nrl_mean

site: $(READY)  ## build the documentation as a site in out/site
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet

diagrams: $(READY)  ## draw docs/concepts/diagrams again where one has changed (npm, Chromium)
	$(BIN)/python -m docs.concepts.diagrams.render

engines: $(READY)  ## images for the tests that start containers (podman, mmdebstrap, as root); some minutes
	$(BIN)/python -m tests.deploy.manifests.engine

clean:  ## remove what can be built again
	rm -f *.so; find protocol agents world deploy -name '*.so' -delete
	rm -rf .venv out build *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
