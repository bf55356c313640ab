# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The few pieces of HTML that a report is made of. Texts are escaped here, and nowhere else."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any, Iterable, Mapping, NamedTuple, Sequence

STYLE = Path(__file__).resolve().parents[1] / "data" / "report.css"

Report = Mapping[str, Any]
"""What is in report.json."""


def page(title: str, parts: Iterable[str]) -> str:
    """A whole page, its style inside."""
    style = STYLE.read_text(encoding="utf-8")
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def section(name: str, title: str, meaning: str, *content: str) -> str:
    """A part of the page under a headline, with what it means. name: to link to."""
    body = "\n".join(content)
    return f'<section id="{escape(name)}">\n<h2>{escape(title)}</h2>\n<p>{escape(meaning)}</p>\n{body}\n</section>'


def headline_figures(figures: Iterable[tuple[str, str]]) -> str:
    """Numbers and, under each, what it is."""
    tiles = "\n".join(f"<div><b>{escape(number)}</b><span>{escape(what)}</span></div>" for number, what in figures)
    return f'<div class="figures">\n{tiles}\n</div>'


def card(camera: str, scan: str, title: str, caption: str) -> str:
    """Two pictures side by side, paths relative to the page, and a caption."""
    pictures = (
        f'<img src="{escape(camera)}" width="640" height="480" alt="camera: {escape(title)}">'
        f'<img src="{escape(scan)}" width="640" height="640" alt="scan from above: {escape(title)}">'
    )
    return (
        f'<figure>\n<a class="pair" href="{escape(camera)}">{pictures}</a>\n'
        f"<figcaption><b>{escape(title)}</b> {escape(caption)}</figcaption>\n</figure>"
    )


def picture(path: str, alt: str, caption: str) -> str:
    """One picture, path relative to the page, and a caption."""
    image = f'<a href="{escape(path)}"><img src="{escape(path)}" alt="{escape(alt)}"></a>'
    return f'<figure class="picture">{image}<figcaption>{escape(caption)}</figcaption></figure>'


def plot(stem: str, alt: str) -> str:
    """A plot that is there for a light and for a dark page."""
    return (
        f'<figure class="plot"><picture><source srcset="{escape(stem)}-dark.svg" '
        f'media="(prefers-color-scheme: dark)"><img src="{escape(stem)}.svg" alt="{escape(alt)}"></picture></figure>'
    )


class Cell(NamedTuple):
    """A cell of a table. look: a class of the style, such as good or bad."""

    text: str
    look: str = ""


def table(head: Sequence[str], rows: Iterable[Sequence[Cell]], texts: int) -> str:
    """The first `texts` columns are words, the others numbers."""
    lines = [_row("th", [Cell(each) for each in head], texts), *(_row("td", row, texts) for row in rows)]
    return '<div class="table"><table>\n' + "\n".join(lines) + "\n</table></div>"


def _row(tag: str, cells: Sequence[Cell], texts: int) -> str:
    looks = [f"{cell.look} number" if i >= texts else cell.look for i, cell in enumerate(cells)]
    return "<tr>" + "".join(_cell(tag, cell.text, look.strip()) for cell, look in zip(cells, looks)) + "</tr>"


def _cell(tag: str, text: str, look: str) -> str:
    return f'<{tag} class="{look}">{escape(text)}</{tag}>' if look else f"<{tag}>{escape(text)}</{tag}>"


def number(value: float | None, form: str) -> str:
    """As its form has it; a dash where there is none."""
    return "-" if value is None else form.format(value)
