"""`disknav scenario`: list the library, and make scenario files."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from deploy.cli import options
from deploy.output import check_text, write_text
from protocol.scenario.model import Scenario

ScenarioFile = Annotated[Path, options.out("Scenario file to write; '-' is standard output.")]
app = typer.Typer(name="scenario", help="List, show and generate scenarios.", no_args_is_help=True)


@app.command("list")
def list_() -> None:
    """List the library.

    Example: disknav scenario list
    """
    from rich.console import Console
    from rich.table import Table

    from deploy.library.load import catalogue

    table = Table("name", "robots", "what it shows", box=None, header_style="bold", pad_edge=False)
    for entry in catalogue():
        table.add_row(entry.name, entry.robots, entry.text)
    Console(width=None if sys.stdout.isatty() else 120).print(table)


@app.command()
def show(
    scenario: options.Scenario, seed: options.Seed = None, setting: options.SettingOptions = None
) -> None:
    """Print a scenario as a TOML file, checked and complete.

    Example: disknav scenario show figure-1 --set control.k=80 > mine.toml
    """
    from deploy.library.load import read

    _write(read(scenario, setting or [], seed))


@app.command()
def new(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="random, swap, or any library name.")],
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random values.")] = 0,
    out: ScenarioFile = Path("-"),
    robots: Annotated[int | None, options.robots(1)] = None,
    density: Annotated[
        float | None, typer.Option(help="Disk area over workspace area, up to 0.35 (random).")
    ] = None,
    unequal: Annotated[float | None, typer.Option(help="Spread of the radii, 0 to 0.5 (random).")] = None,
    jitter: Annotated[
        float | None, typer.Option(help="Largest displacement of the starts, m (swap).")
    ] = None,
) -> None:
    """Generate a scenario file from a seed.

    Examples: disknav scenario new random --robots 12 --density 0.2 --unequal 0.3 --seed 4 -o crowd.toml;
    disknav scenario new swap --robots 8 --jitter 0.005;
    disknav scenario new figure-3d --seed 9
    """
    from deploy.library.load import generate

    wanted = {"robots": robots, "density": density, "unequal": unequal, "jitter": jitter}
    given = {key: value for key, value in wanted.items() if value is not None}
    check_text(out)
    _write(generate(kind, seed, given), out)


@app.command("import")
def import_(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Map of map_server (.yaml), or benchmark: db-CBS (.yaml), LSC-DR (.json), MovingAI (.scen), "
            "SMGLib (.xml).",
            exists=True,
            dir_okay=False,
        ),
    ],
    out: ScenarioFile = Path("-"),
    robots: Annotated[int, options.robots(1)] = 5,
    radius: Annotated[float, typer.Option(min=1e-3, help="Radius of the robots, m (maps, MovingAI).")] = 0.2,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random values (maps).")] = 0,
    error: Annotated[
        float, typer.Option(min=0.0, max=10.0, help="How far obstacles may reach into free space, m (maps).")
    ] = 0.05,
    obstacles: Annotated[Path | None, typer.Option(help="World file with obstacles (LSC-DR).")] = None,
) -> None:
    """Make a scenario file from another tool's: a map, with random starts and goals, or a benchmark.

    Examples: disknav scenario import office.yaml --robots 5 --radius 0.2 -o office.toml;
    disknav scenario import maze-32-32-4-even-1.scen --robots 10 --radius 0.3 -o maze.toml
    """
    from deploy.library.benchmarks import Options, imported

    check_text(out, file, obstacles)
    _write(imported(file, Options(robots, radius, seed, error, obstacles, out.parent)), out)


@app.command()
def schema() -> None:
    """Print the JSON schema of scenario files, for editors that check TOML.

    Example: disknav scenario schema > scenario.schema.json
    """
    import json

    from protocol.scenario.file import json_schema

    print(json.dumps(json_schema(), indent=2))


def _write(scenario: Scenario, output: Path = Path("-")) -> None:
    from protocol.scenario.file import write_toml

    write_text(write_toml(scenario), output)
