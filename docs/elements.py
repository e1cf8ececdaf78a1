"""The tables of the papers' elements, from docs/papers/elements.csv."""

import csv
import itertools
import re
from pathlib import Path

COLUMNS = ("element", "what", "verdict", "number", "where")
TITLES = {
    "strawberry": "Strawberry handling arm",
    "hydrolek": "HydroLek: feedback laws as solvers",
    "tomato": "Tomato pointing arm",
    "redundant7": "redundant7: differential evolution",
}


def table(file: Path) -> str:
    """Return a table for each paper, in Markdown.

    What is found comes before where: names of code are long, and may be broken.
    """
    with file.open(newline="", encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    made = []
    for paper, of_paper in itertools.groupby(rows, key=lambda row: row["paper"]):
        made += [f"### [{TITLES[paper]}]({paper}.md)", ""]
        made += [f"| {' | '.join(COLUMNS)} |", "|" + "---|" * len(COLUMNS)]
        for row in of_paper:
            # Files are what `agrik-fast paper NAME` writes into its folder.
            places = [
                _name(place.removeprefix("agrik_fast.").removeprefix(f"{paper}/"))
                for place in filter(None, row["where"].split(";"))
            ]
            cells = (row["element"], row["says"], row["verdict"], row["number"], ", ".join(places))
            made.append(f"| {' | '.join(cells)} |")
        made.append("")
    return "\n".join(made)


def _name(code: str) -> str:
    """Return a name in the typewriter's face that may be broken behind dots and underscores."""
    broken = re.sub(r"([._])", r"\1<wbr>", code)
    return f"<code>{broken}</code>"
