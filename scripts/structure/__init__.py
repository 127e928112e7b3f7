"""The project's structure rules, as code; run by scripts/check_structure.py."""
