# make demo    simulate a campaign with known truth, run everything on it, print found against true
# make test    the tests;  make test-all  the slow ones too
# make lint    style, types, import rules;  make format  put the style right
# make lock    resolve requirements.lock anew
# Each does all the set-up alone, into .venv: the first time about a minute, then nothing.

PYTHON ?= python3
BIN := .venv/bin
# an inherited 1 would make every start compile every module again
export PYTHONDONTWRITEBYTECODE =

.PHONY: demo test test-all lint format lock clean

demo: .venv/ready
	@$(BIN)/tiltwatch demo

test: .venv/ready
	@$(BIN)/python -m pytest

test-all: .venv/ready
	@$(BIN)/python -m pytest -m "slow or not slow" --timeout=1200

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: .venv/ready
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

lock: .venv/ready
	$(BIN)/uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
		--no-header --extra dev pyproject.toml -o requirements.lock

.venv/ready: requirements.lock pyproject.toml infra/install.sh
	@PYTHON="$(PYTHON)" sh infra/install.sh
	@touch $@

clean:
	rm -rf .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
