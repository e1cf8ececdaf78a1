"""Write the JSON beside each bundled robot file, from which the package reads it quickly."""

from agrik_fast.robot import _prepared, _sources
from agrik_fast.robot._definition import from_robot_file


def main() -> None:
    for path in sorted(_sources.BUNDLED.glob("*.toml")):
        written = path.with_suffix(".json")
        written.write_text(_prepared.text(from_robot_file(path)), encoding="utf-8")
        print(written.name)


if __name__ == "__main__":
    main()
