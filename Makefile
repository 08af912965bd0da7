# Every target makes .venv where it is missing, so each works on a fresh clone.
PYTHON  ?= python3
WORKERS ?= 2
EXTRAS  := evaluate,render,train,onnx,dev
RLLIB   := rllib,ray,train
TORCHRL := torchrl,train,render
CUDA    := cuda,torchrl,train
SHORT   := not slow and not reproduces and not wheel and not faults and not site
FAULTS  ?= 100
MUTANTS ?= equations weighting estimators statistics claims training learned_layers
BIN     := .venv/bin
READY   := .venv/.ready
LIGHT   := .venv/.light
TESTS   := pytest pytest-timeout hypothesis
PLAYED := near es1-clean es1 real ants2008 es2 es3 mg1-square mg1-hexagon mg1-dodecagon two-prey moving-prey two-nests
REPLAYS := $(patsubst %,build/replays/waypoints-%.html,05 10 25 50)

.DEFAULT_GOAL := help
.PHONY: help install demo test faults mutants test-wheel test-browser test-docs test-ray test-rllib test-torchrl \
	test-cuda test-targets check lint dist golden coverage bench bench-cuda ladder reproduce pictures tutorials model-cards score-plot scores docs \
	docs-serve docs-equations counts clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-16s %s\n", $$1, $$2 }' Makefile

# A virtual environment with this package in it, by uv where it is installed: folder, constraints,
# what to install.
define make_venv
	@if command -v uv >/dev/null; then \
		uv venv --quiet --seed --allow-existing --python $(PYTHON) $(1) && \
		uv pip install --python $(1)/bin/python --constraint $(2) --editable $(3); \
	else \
		$(PYTHON) -m venv $(1) && \
		$(1)/bin/python -m pip install -qq --constraint $(2) --editable $(3); \
	fi
endef

$(READY): pyproject.toml constraints.txt
	@echo 'installing all that is tested, torch too, into .venv: 3.6 GB, a few minutes'
	$(call make_venv,.venv,constraints.txt,'.[$(EXTRAS)]')
	@touch $(LIGHT) $@

$(LIGHT): pyproject.toml constraints.txt
	@echo 'installing what evaluates and draws into .venv, without torch: 700 MB, half a minute'
	$(call make_venv,.venv,constraints.txt,'.[evaluate]')
	@touch $@

.venv-rllib/.ready: pyproject.toml constraints-rllib.txt
	$(call make_venv,.venv-rllib,constraints-rllib.txt,'.[$(RLLIB)]' $(TESTS))
	@touch $@

.venv-torchrl/.ready: pyproject.toml constraints.txt
	$(call make_venv,.venv-torchrl,constraints.txt,'.[$(TORCHRL)]' $(TESTS))
	@touch $@

.venv-cuda/.ready: pyproject.toml constraints.txt
	$(call make_venv,.venv-cuda,constraints.txt,'.[$(CUDA)]' $(TESTS))
	@touch $@

.venv-docs/.ready: pyproject.toml constraints.txt
	$(call make_venv,.venv-docs,constraints.txt,'.[docs]')
	@touch $@

.venv-mutants/.ready: pyproject.toml constraints.txt
	$(call make_venv,.venv-mutants,constraints.txt,'.[mutants]')
	@touch $@

install: $(READY)  ## make .venv with the tested set; quick when nothing changed

demo: $(LIGHT)  ## evaluate three baselines on es1: table, boxplot, dataset, replay; a minute, no torch
	$(BIN)/swarm-forage evaluate es1 nc ssgikf ssgiff:beta=0.001 --episodes 30 \
		--workers $(WORKERS) --out runs/demo --plot runs/demo.png
	$(BIN)/swarm-forage watch es1 ssgikf --seconds 600 --html runs/demo.html

model-cards: .venv-docs/.ready  ## a card of each bundled policy, as the Hugging Face Hub takes it: build/model-cards/
	cd docs/hooks && $(CURDIR)/.venv-docs/bin/python cards.py $(CURDIR)/build/model-cards

score-plot: $(READY)  ## the boxplot of the README: docs/images/score.png
	$(BIN)/swarm-forage evaluate es1 nc ssgikf dsgikf ssgiff:beta=0.001 ssgiff dsgiff \
		dsgiff-frequent:beta=0.003 learned-weighting learned-motion learned-both \
		--workers $(WORKERS) --out runs/score-plot --plot docs/images/score.png

scores: $(READY)  ## the scores that `swarm-forage list` tells: baselines/evaluation/scores.json
	$(BIN)/python -m baselines.evaluation.scores --workers $(WORKERS)

test: $(READY)  ## the tests, without those marked slow, reproduces or wheel; some ten minutes on two cores
	$(BIN)/pytest -n $(WORKERS) --dist worksteal -m '$(SHORT)'

faults: $(READY)  ## bring about faults of each kind; FAULTS=10: a tenth as often
	FAULTS=$(FAULTS) $(BIN)/pytest -n $(WORKERS) --dist worksteal -m faults tests/faults

mutants: $(READY) .venv-mutants/.ready  ## single faults in a copy of the code: do the tests notice? (days)
	tests/mutants/run build/mutants $(MUTANTS)

test-wheel: $(READY)  ## the wheel alone and with each extra alone, installed from the index
	$(BIN)/pytest -n $(WORKERS) --dist worksteal -m wheel tests/packaging

test-browser: $(READY)  ## the replay in Chromium, which must be there (`make test`: if it is)
	@for name in chromium chromium-browser google-chrome google-chrome-stable; do \
		command -v $$name && exit 0; \
	done; echo 'no Chromium on the PATH; on Debian: apt-get install chromium' >&2; exit 1
	$(BIN)/pytest -m browser tests/rendering/replay

test-rllib: .venv-rllib/.ready  ## the RLlib example, in .venv-rllib, as ray pins gymnasium
	.venv-rllib/bin/pytest -m rllib tests/plugs

test-ray: .venv-rllib/.ready  ## commands on a Ray cluster of this machine, in .venv-rllib
	.venv-rllib/bin/pytest -m ray tests/plugs

test-torchrl: .venv-torchrl/.ready  ## the TorchRL and BenchMARL examples, in .venv-torchrl
	.venv-torchrl/bin/pytest -m torchrl tests/plugs tests/training

test-cuda: .venv-cuda/.ready  ## the kernels of a GPU, in .venv-cuda: without one, and on one if found
	.venv-cuda/bin/pytest -m 'cuda or gpu' tests/cuda

test-targets: $(READY)  ## ticks in WebAssembly and on an emulated Cortex-M4; skipped without node, ARM's GCC, QEMU
	$(BIN)/pytest -m 'not slow' tests/targets

ladder: .venv-torchrl/.ready  ## train what is missing of the ladder, telling the time left, and write docs/ladder.md (a night)
	.venv-torchrl/bin/swarm-forage benchmark cards --missing --workers $(WORKERS)
	.venv-torchrl/bin/swarm-forage benchmark ladder --workers $(WORKERS) --out docs/data/ladder.parquet \
		--page docs/ladder.md

lint: $(READY)  ## style, types, the house, spelling
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy --platform win32
	$(BIN)/mypy --platform darwin
	$(BIN)/lint-imports
	$(BIN)/codespell

check: lint test  ## what a commit needs: lint, then test

dist: $(READY)  ## wheel and source distribution into dist/, their contents checked
	rm -f dist/*.whl dist/*.tar.gz
	$(BIN)/python -m hatchling build -d dist
	DIST=dist $(BIN)/pytest -q tests/packaging/test_dist.py

golden: $(READY)  ## write tests/golden/data anew: what the swarm does, bit for bit
	$(BIN)/python -m tests.golden.record

coverage: $(READY)  ## line and branch coverage, kernels run as plain Python (slow)
	NUMBA_DISABLE_JIT=1 $(BIN)/coverage run -m pytest --timeout=3600 -m '$(SHORT)'
	$(BIN)/coverage report

bench: $(READY)  ## robot-steps per second against the budgets
	$(BIN)/swarm-forage bench

bench-cuda: .venv-cuda/.ready  ## all figures of a GPU: speed, PPO from scratch, CMA-ES (needs one)
	.venv-cuda/bin/swarm-forage bench --device cuda
	.venv-cuda/bin/swarm-forage train motion es1 --device cuda --physics kinematic \
		--out runs/ppo_on_gpu
	.venv-cuda/bin/swarm-forage evaluate es1 ssgikf learned-both --device cuda \
		--physics kinematic --episodes 10000 --out runs/evaluated_on_gpu
	.venv-cuda/bin/swarm-forage train motion es1 --device cuda --physics kinematic \
		--algorithm cma --worlds 600 --out runs/cma_on_gpu

reproduce: $(READY)  ## the claims and figures of the three papers, boids that forage, faulty robots and other worlds (hours)
	$(BIN)/swarm-forage reproduce social-odometry --episodes adaptive \
		--workers $(WORKERS) --page docs/papers/social_odometry.md
	$(BIN)/swarm-forage reproduce ants2008 --episodes adaptive --workers $(WORKERS) \
		--page docs/papers/ants2008.md
	$(BIN)/swarm-forage reproduce adaptive-boids --workers $(WORKERS) \
		--page docs/papers/adaptive_boids.md
	$(BIN)/swarm-forage reproduce boids-foraging --physics kinematic --workers $(WORKERS) \
		--page docs/papers/boids_foraging.md
	$(BIN)/swarm-forage reproduce robustness --set task.duration=900 --episodes 30 \
		--physics kinematic --workers $(WORKERS) --page docs/papers/robustness.md
	$(BIN)/swarm-forage reproduce transfer --set task.duration=1800 --seed 1000 \
		--physics kinematic --workers $(WORKERS) --page docs/papers/transfer.md

pictures: $(READY)  ## the stills and the clip of README and docs
	$(BIN)/swarm-forage watch es1 ssgikf --seed 1 --start 571 --seconds 1 --select 7 \
		--size 800 --frame docs/images/es1.png
	$(BIN)/swarm-forage watch es1 ssgikf --seed 1 --start 420 --seconds 100 --speed 12 \
		--size 480 --video docs/images/es1.gif
	$(BIN)/swarm-forage watch waypoints-05 boids-adaptive --seconds 60 --select 2 \
		--size 720 --frame docs/images/waypoints.png

tutorials: $(READY)  ## run the tutorials whose code is another than that of their kept outputs: docs/tutorials (minutes)
	$(BIN)/python docs/hooks/tutorial_pages.py

build/replays/waypoints-%.html: .venv-docs/.ready
	@mkdir -p $(@D)
	.venv-docs/bin/swarm-forage watch waypoints-$* boids-adaptive --seed 1 --html $@

build/replays/.played: docs/hooks/playgrounds.py .venv-docs/.ready
	.venv-docs/bin/python docs/hooks/playgrounds.py $(@D) $(PLAYED)
	@touch $@

build/replays/play.html: .venv-docs/.ready
	@mkdir -p $(@D)
	.venv-docs/bin/swarm-forage play es1 ssgikf learned-both --html $@

docs: .venv-docs/.ready $(REPLAYS) build/replays/play.html build/replays/.played  ## build the site into site/: strict, nothing fetched from elsewhere
	NO_MKDOCS_2_WARNING=1 .venv-docs/bin/python -m mkdocs build --quiet
	.venv-docs/bin/python docs/hooks/check_site.py site

docs-serve: docs  ## show the site at http://localhost:8000
	.venv-docs/bin/python -m http.server --directory site 8000

test-docs: docs $(READY)  ## the site in Chromium, which must be there, at 390 and 1280 px
	$(BIN)/pytest -m site tests/docs

docs-equations: $(READY)  ## write docs/equations.md anew from the docstrings
	$(BIN)/python docs/hooks/make_equations.py

counts:  ## count the source, and write the tables of docs/architecture.md anew
	$(PYTHON) docs/hooks/count.py

clean:  ## remove caches and build outputs; environments and runs/ stay
	rm -rf build dist site *.egg-info .coverage .hypothesis .import_linter_cache .mypy_cache \
		.pytest_cache .ruff_cache
	find swarm_forage_env baselines training tests docs examples -name __pycache__ -prune \
		-exec rm -rf {} +
