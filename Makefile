# `make demo` and `make test` set up what they need from Python 3.11 or newer and the package registry.
PYTHON ?= $(shell for p in python3.13 python3.12 python3.11 python3; do \
  command -v $$p >/dev/null 2>&1 && $$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
BIN := .venv/bin
READY := .venv/.ready
COMPILED := .venv/.compiled
KERNEL := .venv/.kernel
# What runs for every message; mypyc makes C of it, with the same trajectories to the last bit.
INNER := $(addprefix protocol/bus/,events.py drive.py local.py zenoh.py) \
  $(addprefix protocol/geometry/,disk.py polygon.py) \
  $(addprefix protocol/wire/,cursor.py reader.py codec.py) \
  $(addprefix agents/,localisation/estimate.py safety_filter.py hearing.py robot.py) \
  $(addprefix agents/shell/,contact.py subscriptions.py node.py) \
  $(addprefix agents/peers/,roster.py awaited.py attention.py far.py state.py reader.py neighbours.py link.py) \
  $(addprefix agents/navigation/,far_field.py slice.py flow.py pace.py deadlock.py obstacles.py attraction.py) \
  $(addprefix agents/lines/,polygon.py safe_velocity.py line.py own_set.py boundary.py placement.py ends.py tangent.py things.py robot_pair.py initial_lines.py separating_lines.py) \
  $(addprefix agents/lines/negotiation/,entries.py near.py far.py) \
  $(addprefix agents/bodies/,point.py inertial.py) \
  $(addprefix protocol/bodies/,base.py sweep.py) \
  $(addprefix agents/laws/,reciprocity/encounters.py reciprocity/roundabout.py jams/giving_way.py jams/dispersal.py jams/right_of_way.py view.py foresight.py softening.py gradient.py reciprocity/velocity_obstacle.py reciprocity/velocity_program.py reciprocity/reciprocal.py) \
  $(addprefix world/coordinator/,commands.py roster.py life.py lives.py coordinator.py) \
  $(addprefix world/plants/,base.py integrator.py) \
  $(addprefix world/judge/,verdict.py record.py referee.py) \
  $(addprefix world/sensing/,position.py odometry.py) \
  $(addprefix world/,simulation.py world.py) \
  $(addprefix world/shell/,run.py publishers.py pacing.py node.py)

# What a certificate's search runs; numba compiles it for whoever comes first, which takes as long as a whole proof.
SEARCH := $(wildcard deploy/theory/certify/boxes/*.py)

.DEFAULT_GOAL := help
.PHONY: help setup compile inner site demo test fast check collect golden bench fuzz figures diagrams engines clean

help:  ## say what there is
	@awk -F':.*## ' '/^[a-z]+:.*## / {printf "  make %-9s %s\n", $$1, $$2}' Makefile

setup: $(READY) $(COMPILED) $(KERNEL)  ## build .venv with everything that running and testing needs, and compile

compile: $(COMPILED)  ## make C of the inner loops again, after a change to them

inner:
	@echo $(INNER)

$(COMPILED): $(READY) compile.py Makefile $(INNER)
	@mkdir -p build; rm -f *__mypyc*.so
	@if $(BIN)/python compile.py $(INNER) >build/compile.log 2>&1; then echo "compiled the inner loops"; \
	  find protocol agents world deploy -name '*.so' -exec touch {} +; \
	else tail -1 build/compile.log | cut -c 1-200; find protocol agents world deploy -name '*.so' -delete; \
	  echo "not compiled (is there a C compiler, are there Python's headers?): runs at half to three quarters of the speed; to try again: touch compile.py"; fi
	@touch $@

$(READY): pyproject.toml
	@test -n "$(PYTHON)" || { echo "disknav needs Python 3.11 or newer; none was found"; exit 1; }
	$(PYTHON) -m venv .venv
	HATCH_BUILD_NO_HOOKS=true $(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[all,test]'
	@touch $@

$(KERNEL): $(READY) $(SEARCH)
	@mkdir -p build; rm -f build/figure-2.certificate.json
	@$(BIN)/python -m disknav certify figure-2 --k 1000 --quiet --out build/figure-2.certificate.json >/dev/null
	@touch $@

demo: $(READY) $(COMPILED)  ## six real processes drive the paper's figure 1; leaves out/figure-1.mcap and .png
	@mkdir -p out
	$(BIN)/disknav run figure-1 --record out/figure-1.mcap --plot out/figure-1.png

check: $(READY)  ## lint, formatting, types, import contracts
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

fast test collect: export PYTHONDONTWRITEBYTECODE =  # hundreds of interpreters: else each compiles its modules itself

collect: $(READY) $(COMPILED)  # once: else each process of pytest-xdist rewrites what all tests assert
	@$(BIN)/python -m pytest --collect-only -qqq >build/collected.log || { cat build/collected.log; exit 1; }

fast: $(READY) $(COMPILED)  ## the part of the suite that takes about a minute
	$(BIN)/python -m pytest -n auto -m 'not slow and not process and not browser and not alone'

test: $(READY) $(COMPILED) $(KERNEL)  ## lint, types, import contracts and the whole suite
	@$(MAKE) --no-print-directory --jobs=2 check collect
	$(BIN)/python -m pytest -n 4 --dist worksteal --durations=20 -m 'not alone'  # many wait for real time
	$(BIN)/python -m pytest --durations=5 -m alone $$(grep -rl --include='test_*.py' 'mark\.alone' tests)

golden: $(READY) $(COMPILED)  ## renew the kept trajectories of the library, and say by how much each has changed
	$(BIN)/python -m tests.golden

bench: $(READY) $(COMPILED)  ## rates and costs, as ratios against floors measured in the same run
	$(BIN)/python -m tests.benchmarks
	$(BIN)/python -m tests.benchmarks.machine.cores
	$(BIN)/python -m pytest tests/benchmarks/machine/bench_cores.py --benchmark-group-by=param:robots --benchmark-columns=min,median

fuzz: $(READY) $(COMPILED)  ## a million damaged inputs for everything that reads what strangers wrote; some minutes
	$(BIN)/python -m tests.fuzz --inputs 1000000

figures: $(READY) $(COMPILED)  ## run all studies; tables, data and pictures in out/; half an hour, goes on after Ctrl-C
	@mkdir -p out
	$(BIN)/disknav run figure-1 --plot docs/pictures/figure-1.png
	$(BIN)/disknav run figure-2 --record out/figure-2.mcap
	$(BIN)/disknav plot out/figure-2.mcap --until 2.5 -o docs/pictures/figure-2.png
	$(BIN)/disknav check figure-2 > out/figure-2.txt
	$(BIN)/python -m deploy.studies.paper.sampled > out/sampled.md
	$(BIN)/python -m deploy.studies.certified --write
	for study in tightness tuning robustness arrival delay scale; do \
	  $(BIN)/disknav study $$study --json out/$$study.json --plot out/$$study.png || exit $$?; done
	$(BIN)/disknav study peers --runs 3 --json out/peers.json --plot out/peers.png

site: $(READY)  ## build the documentation as a site in out/site
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet

diagrams: $(READY)  ## draw docs/concepts/diagrams again where one has changed (npm, Chromium)
	$(BIN)/python -m docs.concepts.diagrams.render

engines: $(READY)  ## images for the tests that start containers (podman, mmdebstrap, as root); some minutes
	$(BIN)/python -m tests.deploy.manifests.engine

clean:  ## remove what can be built again
	rm -f *.so; find protocol agents world deploy -name '*.so' -delete
	rm -rf .venv out build *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
