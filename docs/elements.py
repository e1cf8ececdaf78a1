"""The table of the papers' elements, from docs/papers/elements.csv."""

import csv
from pathlib import Path

COLUMNS = ("paper", "element", "what", "where", "verdict", "number")


def table(file: Path) -> str:
    """Return the table in Markdown."""
    with file.open(newline="", encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    made = [f"| {' | '.join(COLUMNS)} |", "|" + "---|" * len(COLUMNS)]
    for row in rows:
        places = []
        for place in filter(None, row["where"].split(";")):
            # Files are what `agrik-fast paper NAME` writes into its folder.
            short = place.removeprefix("agrik_fast.").removeprefix(f"{row['paper']}/")
            places.append(f"`{short}`")
        cells = (
            f"[{row['paper']}]({row['paper']}.md)",
            row["element"],
            row["says"],
            ", ".join(places),
            row["verdict"],
            row["number"],
        )
        made.append(f"| {' | '.join(cells)} |")
    return "\n".join(made) + "\n"
