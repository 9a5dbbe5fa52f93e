"""What the site has besides the files of docs/: pages from elsewhere in the tree, the gallery, notebooks, and MathML.

A hook of MkDocs (mkdocs.yml). Links between files of the tree become links between pages; what has no page is shown
without a link, its path as the title.
"""

from __future__ import annotations

import html
import json
import os
import re
import tomllib
from pathlib import Path
from posixpath import dirname, join, normpath, relpath

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
PAGES = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "benchmarks/RESULTS.md": "benchmarks.md",
}
"""Pages from files outside docs/."""
NOTEBOOKS = ("swimmer", "filaments")
FIRST = ("proteins", "swimmer", "swarm_2d", "escrt_bridge", "closing_neck", "container", "writhing")
"""Scenes with which the gallery begins."""
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s#]*)(#[^()\s]*)?\)")
MATHEMATICS = re.compile(r'<(div|span) class="arithmatex">\\[\[(](.*?)\\[\])]</\1>', re.DOTALL)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what is made: pages, and the pictures that they show."""
    made = {page: (ROOT / source).read_text(encoding="utf-8") for source, page in PAGES.items()}
    made["gallery.md"] = gallery()
    for name in NOTEBOOKS:
        made[f"notebooks/{name}.md"] = notebook(ROOT / "docs" / "notebooks" / f"{name}.ipynb")
    for page, content in made.items():
        files.append(File.generated(config, page, content=content))
    for picture in (ROOT / "benchmarks").glob("*.png"):
        files.append(File.generated(config, f"benchmarks/{picture.name}", abs_src_path=str(picture)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Links between files of the tree become links between pages."""
    origin = {made: source for source, made in PAGES.items()}.get(page.file.src_uri, f"docs/{page.file.src_uri}")

    def target(link: re.Match[str]) -> str:
        bang, text, path, anchor = link.group(1), link.group(2), link.group(3), link.group(4) or ""
        if not path or re.match(r"[a-z]+:", path):
            return link.group()
        whole = normpath(join(dirname(origin), path))
        known = PAGES.get(whole, whole.removeprefix("docs/"))
        if files.get_file_from_path(known) is None:
            if not (ROOT / whole).exists():
                return link.group()  # MkDocs warns of it
            return f'<span title="{whole}">{text}</span>'
        return f"{bang}[{text}]({relpath(known, dirname(page.file.src_uri) or '.')}{anchor})"

    parts = re.split(r"(^```.*?^```$)", _indented(markdown), flags=re.DOTALL | re.MULTILINE)
    return "".join(part if part.startswith("```") else LINK.sub(target, part) for part in parts)


def _indented(markdown: str) -> str:
    """What belongs to a numbered item begins after three spaces elsewhere, and after four in Python's Markdown."""
    lines, in_item = [], False
    for line in markdown.split("\n"):
        in_item = bool(re.match(r"\d+\. ", line)) or (in_item and (not line or line.startswith("   ")))
        lines.append(f" {line}" if in_item and line.startswith("   ") else line)
    return "\n".join(lines)


def on_page_content(content: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Equations in LaTeX become MathML, which browsers show without a script."""
    from latex2mathml.converter import convert

    def mathml(found: re.Match[str]) -> str:
        return convert(html.unescape(found.group(2)), display="block" if found.group(1) == "div" else "inline")

    return MATHEMATICS.sub(mathml, content)


def gallery() -> str:
    """The page of the gallery: poster, title and command of each scene of which docs/gallery has a picture."""
    lines = [
        "# Gallery",
        "",
        "First, middle and last frame of runs of the shipped scenes, as each run leaves them in `poster.png`. "
        "`python docs/gallery.py` makes these pictures.",
        "",
    ]
    pictures = {path.stem: path for path in sorted((ROOT / "docs" / "gallery").glob("*.jpg"))}
    for picture in [pictures.pop(name) for name in FIRST if name in pictures] + list(pictures.values()):
        path = ROOT / "scenes" / f"{picture.stem}.toml"
        title = tomllib.loads(path.read_text(encoding="utf-8")).get("title") or picture.stem
        command = f"`warp-rods run scenes/{path.name}`"
        lines += [f"## {title}", "", f"![{title}](gallery/{picture.name})", "", command, ""]
    return "\n".join(lines)


def notebook(path: Path) -> str:
    """A notebook as a page: its words and its code, and where it is."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    parts = ["".join(c["source"]) if c["cell_type"] == "markdown" else _fenced("".join(c["source"])) for c in cells]
    title, *rest = parts
    where = f"This page is the notebook `{os.path.relpath(path, ROOT)}`, without its outputs."
    return "\n\n".join([title, where, *rest]) + "\n"


def _fenced(code: str) -> str:
    return f"```python\n{code}\n```"
