"""`disknav setup`: prepare keys, hosts, orchestrators and bases, and examine this machine."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.cli import options
from deploy.manifests import Orchestrator
from deploy.output import EXIT_ARRIVED, EXIT_OTHERWISE, check_text, is_standard_output, write_json
from deploy.run.options import fresh_run_name
from deploy.security.membership import KeyRing
from deploy.security.roster import OPERATOR
from protocol.errors import UsageError
from protocol.keys import checked_run
from protocol.process.signals import STOP

if TYPE_CHECKING:
    from deploy.software import Finding

app = typer.Typer(
    name="setup", help="Prepare keys, hosts and bases; examine this machine.", no_args_is_help=True
)
_MARKS = {"good": ("ok", "green"), "note": ("--", "yellow"), "bad": ("!!", "red")}


@app.command()
def keys(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Directory to create.")],
    scenario: Annotated[
        str,
        typer.Option(
            "--scenario",
            "-s",
            help="A scenario file or library name: keys for its robots, and for those that its orders add.",
        ),
    ],
    run: options.FreshRun = None,
    host: Annotated[
        list[str] | None, typer.Option(help="Further name or address of the router; repeatable.")
    ] = None,
    hosts: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Table of hosts: one router key per host, for its robots only."),
    ] = None,
    days: Annotated[float, typer.Option(min=0.0, help="Days of validity.")] = 30.0,
    force: Annotated[bool, typer.Option("--force", help="Replace existing keys.")] = False,
) -> None:
    """Make an authority and one certificate each for router, world, monitor, operator and every robot.

    With [b]--hosts[/b] each host's router has its own, valid for the robots of that host only.

    With [b]--secure DIR[/b] other commands use them: every link is TLS with certificates at both ends, and
    the router lets each robot write under its own id only. A host needs ca.pem, roster.json and the two files
    of each role that runs there.

    Example: disknav setup keys keys --scenario figure-1 --host 10.0.0.1 && disknav run figure-1 --secure keys
    """
    from deploy.library.load import read
    from deploy.processes.hosts.table import read_hosts, roster_of
    from deploy.security.keystore import create
    from deploy.security.roster import KeyRoster

    name = fresh_run_name() if run is None else checked_run(run)
    found = read(scenario)
    if hosts is not None and host:
        raise UsageError("the table has the address of each router: leave out --host, or --hosts")
    if hosts is None:
        roster = KeyRoster(name, tuple(sorted({*found.ids, *(spec.id for spec in found.newcomers)})))
    else:
        roster = roster_of(name, read_hosts(hosts, found))
    end = create(directory, roster, hosts=host or (), days=days, force=force)
    print(
        f"{directory}: {len(roster.roles)} certificates for the run {name}, "
        f"valid until {end:%Y-%m-%d %H:%M} UTC"
    )


@app.command()
def hosts(
    table: Annotated[
        Path, typer.Argument(metavar="TABLE", help="Table of hosts (TOML), as for run --hosts.")
    ],
) -> None:
    """Check every host: reach, version, clock, port and space.

    Example: disknav setup hosts hosts.toml

    Exit status: 0 all are fit for a run, 1 one is not, 2 the table is invalid.
    """
    from concurrent.futures import ThreadPoolExecutor

    from deploy.processes.hosts.prepare import check
    from deploy.processes.hosts.table import read_hosts

    listed = read_hosts(table).hosts
    with ThreadPoolExecutor(len(listed)) as pool:
        about = zip(listed, pool.map(check, listed), strict=True)
        found = [(host.name, each) for host, findings in about for each in findings]
    _print(found)
    fit = all(each.level != "bad" for _, each in found)
    raise typer.Exit(EXIT_ARRIVED if fit else EXIT_OTHERWISE)


@app.command()
def deploy(
    orchestrator: Annotated[Orchestrator, typer.Argument(metavar="ORCHESTRATOR", help="Orchestrator.")],
    scenario: options.Scenario,
    out: Annotated[Path, options.out("Folder to make.", metavar="FOLDER")],
    run: options.FreshRun = None,
    mode: options.ModeOption = "realtime",
    seed: options.Seed = None,
    setting: options.SettingOptions = None,
    image: Annotated[
        str | None,
        typer.Option(help="compose, kubernetes: image with this software; default localhost/disknav."),
    ] = None,
    wait: Annotated[
        float, typer.Option(min=1.0, help="Seconds to wait for router, world and robots.")
    ] = 300.0,
    router: Annotated[
        str | None,
        typer.Option(
            metavar="ENDPOINT",
            help="systemd: endpoint at which the fleet's router listens; default tls/127.0.0.1:7447.",
        ),
    ] = None,
    days: Annotated[float, typer.Option(min=0.0, help="Days of validity of the certificates.")] = 30.0,
) -> None:
    """Write files with which Docker Compose, Kubernetes or systemd runs a scenario, keys included.

    The first lines of the main file say how to start it. Every process gets its own key and no other;
    the folder contains all of them.

    Example: disknav setup deploy compose figure-1 -o fleet && cd fleet && docker compose up
    """
    from deploy.library.load import load
    from deploy.manifests import IMAGE, Plan, installation, write
    from deploy.security.roster import KeyRoster
    from protocol.scenario.file import write_toml

    if orchestrator == "systemd":
        options.refuse({"--image": image}, "systemd runs no containers")
    else:
        options.refuse({"--router": router}, f"{orchestrator} gives the router a name of its own")
    loaded = load(scenario, setting or [], seed)
    if loaded.is_external:
        raise UsageError("external bases cannot be used with keys: start the fleet by hand, without keys")
    added = {spec.id for spec in loaded.newcomers}
    if again := sorted(added & {*loaded.ids}):
        raise UsageError(
            f"orders of the scenario add robot {again[0]} again, and its process would not be started "
            "again; give the added robot another id"
        )
    run_name = fresh_run_name() if run is None else checked_run(run)
    roster = KeyRoster(run_name, tuple(sorted({*loaded.ids, *added})))
    command = str(Path(sys.executable).parent / "disknav")
    endpoint = str(KeyRing(out).endpoint(router))
    plan = Plan(roster, write_toml(loaded), mode, image or IMAGE, command, installation(), endpoint, wait)
    write(out, orchestrator, plan, days)
    print(f"{out}: the run {roster.run} for {orchestrator}")


@app.command()
def calibrate(
    scenario: options.Scenario,
    robot: Annotated[int, typer.Argument(metavar="ROBOT", help="The robot's id in the scenario.")],
    side: Annotated[
        float, typer.Option(min=0.2, max=100.0, help="Side of the square ahead and to the left, m.")
    ] = 0.8,
    speed: Annotated[float, typer.Option(min=0.01, max=10.0, help="Speed, m/s.")] = 0.1,
    rate: Annotated[float, typer.Option(min=0.05, max=10.0, help="Turning rate, rad/s.")] = 0.6,
    wait: Annotated[float, typer.Option(min=1.0, help="Seconds to wait for the base's messages.")] = 10.0,
    router: options.Router = None,
    setting: options.SettingOptions = None,
) -> None:
    """Drive a square with one robot's base, and print bounds for the scenario.

    It needs a router without keys, and no other program may drive this base. It does not avoid obstacles:
    keep the floor free.

    Example: disknav setup calibrate yard.toml 1 --side 1.0

    Exit status: 0 done, 2 invalid, 3 the base's messages are missing or of another type.
    """
    from agents.bases.base import require

    require()  # before the imports that need it
    from deploy.calibrate import Calibration, bounds, square, statements
    from deploy.library.load import load
    from protocol.bus.bus import drive
    from protocol.bus.zenoh import ZenohBus

    loaded = load(scenario, setting or [], None)
    if robot not in loaded.ids:
        raise UsageError(f"{scenario} has no robot {robot}; there are {', '.join(map(str, loaded.ids))}")
    if (base := loaded.base_of(robot)) is None:
        raise UsageError(f'robot {robot} has no base to drive: add [base], or world.plant = "external"')
    bus = ZenohBus(KeyRing().client(OPERATOR, (router,)))
    calibration = Calibration(bus, base.of(robot), square(side, speed, rate), wait)
    drive(calibration, bus)
    STOP.check()
    found = bounds(calibration.log)
    print(
        f"measured: poses at rest within {1e3 * found.noise_bound:.1f} mm and {found.heading:.3f} rad; sides "
        f"off by {100 * found.odometry:.1f} % by odometry, by {100 * found.error:.1f} % of the command;\n"
        f"lag {found.lag:.3f} s; odometry at least every {found.interval:.3f} s; without commands it brakes "
        f"after {found.timeout:.2f} s, by {found.acceleration:.2f} m/s^2\n"
        f"for the scenario, with a margin:\n\n{statements(found)}"
    )


@app.command()
def doctor(json_file: options.JsonFile = None) -> None:
    """Examine this installation and machine, run two robots, and print a remedy for each problem.

    ok: works; --: an optional part is missing; !!: fleets will not run.

    Example: disknav setup doctor

    Exit status: 0 fleets run, 1 something is marked with !!.
    """
    from deploy.software import findings

    check_text(json_file)
    found = [*findings(), _trial()]
    write_json([finding._asdict() for finding in found], json_file)
    if not is_standard_output(json_file):
        _print([("", each) for each in found])
    raise typer.Exit(EXIT_OTHERWISE if any(each.level == "bad" for each in found) else EXIT_ARRIVED)


def _trial() -> Finding:
    from deploy.library.load import load
    from deploy.run.fleet import Fleet
    from deploy.run.options import RunOptions
    from deploy.software import Finding
    from protocol.errors import DisknavError

    try:
        with Fleet(load("head-on", ["time.limit=1.0"]), RunOptions()) as fleet:
            report = fleet.execute()
    except DisknavError as error:
        return Finding("fleet", "bad", f"two robots did not run: {error}", "see the messages above")
    if report["verdict"] == "timeout" and report["collisions"] == 0:
        rate = report["ticks"] / report["wall_time"]
        return Finding("fleet", "good", f"two robots, a world and a router ran {rate:.0f} ticks a second")
    text = f"two robots ran to {report['verdict']}: {report['reason']}"
    return Finding("fleet", "bad", text, "disknav run head-on")


def _print(found: Sequence[tuple[str, Finding]]) -> None:
    """A line for each finding, after the host that it is about, if any; lines that can be copied."""
    from rich.console import Console
    from rich.text import Text

    from deploy.processes.hosts.ssh import printable

    console = Console(soft_wrap=True)
    labels = [(host, each.what) for host, each in found]
    names, width = (max(map(len, column)) for column in zip(*labels, strict=True))
    for host, each in found:
        before, text = f"{host:<{names}}  " if names else "", printable(each.text)
        console.print(Text.assemble(before, _MARKS[each.level], f"  {each.what:<{width}}  {text}"))
        if each.remedy:
            console.print(Text.assemble(" " * (len(before) + width + 4), ("→ ", "dim"), each.remedy))
