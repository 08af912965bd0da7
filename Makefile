# Every target makes .venv where it is missing, so each works on a fresh clone.
PYTHON  ?= python3
WORKERS ?= 2
EXTRAS  := evaluate,calibrate,dev
BIN     := .venv/bin
READY   := .venv/.ready

.DEFAULT_GOAL := help
.PHONY: help install demo score-plot test check lint coverage bench reproduce docs-equations clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-16s %s\n", $$1, $$2 }' Makefile

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install -qq --constraint constraints.txt --editable '.[$(EXTRAS)]'
	@touch $@

install: $(READY)  ## make .venv with the tested set; quick when nothing changed

demo: $(READY)  ## evaluate three baselines on es1: table, boxplot, dataset
	$(BIN)/swarm-forage evaluate es1 nc ssgikf ssgiff --episodes 30 --workers $(WORKERS) \
		--out runs/demo --plot runs/demo.png

score-plot: $(READY)  ## the boxplot of the README: docs/images/score.png
	$(BIN)/swarm-forage evaluate es1 nc ssgikf dsgikf ssgiff dsgiff --episodes 10 --seed 1000 \
		--workers $(WORKERS) --out runs/score-plot --plot docs/images/score.png

test: $(READY)  ## the tests, without those marked slow or reproduces
	$(BIN)/pytest -n $(WORKERS) --dist worksteal -m 'not slow and not reproduces'

lint: $(READY)  ## style, types, the house, spelling
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell

check: lint test  ## what a commit needs: lint, then test

coverage: $(READY)  ## line and branch coverage, kernels run as plain Python (slow)
	NUMBA_DISABLE_JIT=1 $(BIN)/coverage run -m pytest -m 'not slow and not reproduces'
	$(BIN)/coverage report

bench: $(READY)  ## robot-steps per second against the budgets
	$(BIN)/swarm-forage bench

reproduce: $(READY)  ## the claims and figures of the three papers (hours)
	$(BIN)/swarm-forage reproduce social-odometry --workers $(WORKERS) \
		--page docs/papers/social_odometry.md
	$(BIN)/swarm-forage reproduce ants2008 --workers $(WORKERS) --page docs/papers/ants2008.md
	$(BIN)/swarm-forage reproduce adaptive-boids --workers $(WORKERS) \
		--page docs/papers/adaptive_boids.md

docs-equations: $(READY)  ## write docs/equations.md anew from the docstrings
	$(BIN)/python docs/make_equations.py

clean:  ## remove caches and build outputs; .venv and runs/ stay
	rm -rf build dist site *.egg-info .coverage .hypothesis .import_linter_cache .mypy_cache \
		.pytest_cache .ruff_cache
	find swarm_forage_env baselines training tests docs -name __pycache__ -prune -exec rm -rf {} +
