#!/usr/bin/env bash
# Tests of stiction.torch, stiction.jax and stiction.gym, with their packages in a Python environment of their own: build/learners.
set -euo pipefail
cd "$(dirname "$0")/.."
if [[ ! -x build/learners/bin/python ]]; then .venv/bin/python -m venv build/learners; fi
build/learners/bin/python -m pip install -q "torch>=2.4" "jax>=0.4.34" "gymnasium>=1.1" numpy pytest
build/learners/bin/python -m pytest -q -c tests/python/pytest.ini tests/python/test_learners.py tests/python/test_grasps.py
