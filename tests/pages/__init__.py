"""The blocks of code of README.md and docs/."""
