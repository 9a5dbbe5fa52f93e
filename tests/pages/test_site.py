"""What the site must have: every public name, every page in its menu, small pictures, links that lead somewhere."""

import ast
import re
from pathlib import Path

import pytest

from pages.blocks import PAGES, ROOT

NAMES: list[str] = ast.literal_eval(
    ast.parse((ROOT / "warp_rods" / "__init__.pyi").read_text(encoding="utf-8")).body[-1].value
)
MENU = set(re.findall(r"(?m)^ +- .*: ([\w/]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8")))
FROM_ELSEWHERE = {"index.md", "gallery.md", "contributing.md", "changelog.md", "benchmarks.md"}
"""Pages that docs/site.py adds."""
LARGEST = 1.5e6
"""Bytes of all pictures of the gallery."""


def test_the_reference_has_every_public_name():
    """Those of the errors are members of ``wr.errors``."""
    shown = set(re.findall(r"(?m)^::: warp_rods\.(\w+)$", (ROOT / "docs" / "reference.md").read_text(encoding="utf-8")))
    errors = {name for name in NAMES if name.endswith(("Error", "Failure"))}
    assert shown == set(NAMES) - errors


def test_the_menu_has_every_page():
    pages = {page.name for page in PAGES} - {"README.md"}
    notebooks = {f"notebooks/{path.stem}.md" for path in (ROOT / "docs" / "notebooks").glob("*.ipynb")}
    assert pages | notebooks | FROM_ELSEWHERE == MENU


def test_pictures_of_the_gallery_are_small_and_of_scenes():
    pictures = list((ROOT / "docs" / "gallery").iterdir())
    assert sum(path.stat().st_size for path in pictures) < LARGEST
    assert all((ROOT / "scenes" / f"{path.stem}.toml").is_file() for path in pictures)


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_links_between_files_lead_somewhere(page: Path):
    """As the files are read without the site."""
    text = re.sub(r"(?ms)^ *```.*?^ *```$", "", page.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^()\s#]+)(?:#[^()\s]*)?\)", text):
        if not re.match(r"[a-z]+:", target):
            assert (page.parent / target).exists(), target
