#!/usr/bin/env bash
# Makes benchmarks/.venv with the peers in it (Python 3.10 or later with the venv module); 2 GB, most of it Open3D.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
python3 -c 'import ensurepip' 2> /dev/null || {
  echo "error: Python's venv module is missing: apt-get install -y python3-venv" >&2
  exit 1
}
python3 -m venv .venv
.venv/bin/pip install --quiet --disable-pip-version-check -r requirements.txt
.venv/bin/python peers.py --list
