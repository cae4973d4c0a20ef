# make demo    simulate a campaign with known truth, run everything on it, print found against true
# make test    the tests;  make test-all  the slow ones too
# make bench   measure and write benchmarks/RESULTS.md (half an hour, on a machine that does nothing else)
# make lint    style, types, import rules;  make format  put the style right
# make setup   the set-up alone
# make lock    resolve requirements.lock anew, and infra/sbom.cdx.json from it
# make audit   hold the lock against known flaws (3: nobody could be asked, 4: there are some)
# Each does all the set-up alone, into .venv: the first time about two minutes, then nothing.

# which Python .venv is made with; left empty: the first of python3, python3.13, 3.12, 3.11 that fits
PYTHON ?=
BIN := .venv/bin
# tests of one file share what they set up, so files are what is spread over the cores
SIDE_BY_SIDE := -n auto --maxprocesses=4 --dist loadfile
# an inherited 1 would make every start compile every module again
export PYTHONDONTWRITEBYTECODE =

# the set-up that was finished says for which folder; in a checkout that was moved nothing in .venv starts
ifneq ($(shell cat .venv/ready 2>/dev/null),$(CURDIR))
.PHONY: .venv/ready
endif

.PHONY: setup demo test test-all bench lint format lock audit clean

setup: .venv/ready

demo: .venv/ready
	@$(BIN)/tiltwatch demo

test: .venv/ready
	@$(BIN)/python -m pytest $(SIDE_BY_SIDE)

test-all: .venv/ready
	@$(BIN)/python -m pytest $(SIDE_BY_SIDE) -m "slow or not slow" --timeout=1200

bench: .venv/ready
	@$(BIN)/python -m benchmarks.results

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
		--no-header --extra dev --extra dask pyproject.toml -o requirements.lock
	$(BIN)/python infra/sbom.py

audit: .venv/ready
	@$(BIN)/python infra/audit.py

.venv/ready: requirements.lock pyproject.toml infra/install.sh
	@PYTHON="$(PYTHON)" sh infra/install.sh

clean:
	rm -rf .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
