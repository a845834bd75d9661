"""Tables for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def table(title: str, header: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """A table in HTML, below a title; all of it is text."""

    def row(cells: Sequence[object], tag: str) -> str:
        return f"<tr>{''.join(f'<{tag}>{escape(str(cell))}</{tag}>' for cell in cells)}</tr>"

    body = "".join(row(cells, "td") for cells in rows)
    return f"<p>{escape(title)}</p><table><thead>{row(header, 'th')}</thead><tbody>{body}</tbody></table>"
