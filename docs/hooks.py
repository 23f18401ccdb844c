"""Hooks of the documentation's build: pictures of the examples, a page for each package, and equations as MathML.

Equations are converted when the site is built, so that a page needs neither a script nor a network to show them. Each
keeps its TeX as a tooltip.
"""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent
EQUATION = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)
# the public packages, in the order of the reference; its pages are made when the site is built
PACKAGES = (
    *("errors", "shapes", "scene", "core", "particles", "results", "walls", "usd", "elastic", "fluid"),
    *("observers", "coupling", "run", "app"),
)
PAGE = """::: warp_mps.{name}
    options:
      heading_level: 1
      show_submodules: true
      show_root_full_path: true
      show_if_no_docstring: false
"""


def on_files(files: Files, config: Any) -> Files:
    """Add a page for each package, and the pictures of the examples, which the README shows as well."""
    for name in PACKAGES:
        files.append(File.generated(config, f"reference/{name}.md", content=PAGE.format(name=name)))
    for picture in sorted((ROOT / "examples" / "pictures").iterdir()):
        files.append(File.generated(config, f"pictures/{picture.name}", abs_src_path=str(picture)))
    return files


def on_page_content(text: str, page: Any, **_: Any) -> str:
    """Replace TeX by MathML.

    Raises:
        PluginError: An equation holds a command that is unknown.
    """

    def render(match: re.Match[str]) -> str:
        tag, kind, tex = match[1], match[2], html.unescape(match[3]).strip()
        mathml = convert(tex, display="block" if kind == "[" else "inline")
        if unknown := re.search(r"\\[a-zA-Z]+", mathml):
            raise PluginError(f"{page.file.src_uri}: {unknown[0]} is unknown in the equation {tex}")
        # browsers draw a bold variant by its style alone, and would stretch a bar to its subscript
        mathml = re.sub(r'mathvariant="bold(-italic)?"', 'mathvariant="normal" style="font-weight: bold"', mathml)
        mathml = re.sub(r"<mo[^>]*>(&#x0007C;|\|)</mo>", '<mo stretchy="false" lspace="0" rspace="0">|</mo>', mathml)
        return f'<{tag} class="arithmatex" title="{html.escape(tex)}">{mathml}</{tag}>'

    return EQUATION.sub(render, text)
