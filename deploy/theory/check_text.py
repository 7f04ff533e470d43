"""The report of `disknav check` as text for the terminal, and its scope for other laws and external bases."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from deploy.theory.bounds import Bounds
from deploy.theory.check import Assumption, CheckReport, Shortfall
from protocol.scenario.model import Scenario

CAVEAT = (
    "The conditions are sufficient and very conservative; the paper's own simulations never check them. "
    "Where they fail the theory says nothing about arrival."
)


def scope(scenario: Scenario) -> list[str]:
    """Validity of the report for other laws, and the bounds that external bases must keep."""
    law, said = scenario.control.law, []
    if law == "external":
        said.append("The law is external: bounds on k do not apply, and arrival depends on the planners.")
    elif law != "gradient":
        said.append(f"Bounds on k are for the law gradient; arrival with {law} is not proven for any k.")
    if scenario.is_external and scenario.control.filter != "none":
        said += [
            "",
            "External bases: no collision as long as these stated bounds hold, which are not measured here.",
            *_stated(scenario),
        ]
    return said


def _stated(scenario: Scenario) -> Iterator[str]:
    robots: dict[str, list[str]] = {}
    for robot in scenario.ids:
        body, base = scenario.body_of(robot), scenario.base_of(robot)
        if base is not None:
            stands = scenario.world.lease + body.hold + body.speed / body.acceleration
            age = base.age + base.latency
            text = (
                f"continues for {base.patience:g} s without ticks, for {base.timeout:g} s without its "
                f"process; messages take at most {base.latency:g} s; odometry is at most {age:g} s old; "
                f"stands at most {stands:.2g} s after its newest confirmed command"
            )
            robots.setdefault(text, []).append(str(robot))
    for text, ids in robots.items():
        yield f"robot {', '.join(ids)}: {text}"


def render(found: CheckReport) -> RenderableType:
    """Tables and sentences for the terminal."""
    lines = [
        *_assumption_text("Assumption 1 (goals far enough apart)", found.assumption_1),
        *_assumption_text("Assumption 2 (goals off the boundary)", found.assumption_2),
    ]
    bounds: list[RenderableType] = [] if found.bounds is None else [_bounds(found.bounds), Text()]
    said = (*_verdict(found), CAVEAT, *_certificate(found), "", *_practice(found))
    method = Text(_method(found), style="dim")
    return Group(found.facts.table(), Text(), *map(Text, lines), method, Text(), *bounds, *map(Text, said))


def _assumption_text(name: str, found: Assumption) -> list[str]:
    if found.status == "holds":
        least = f", by {found.worst:.4f} m or more" if found.clusters else ""
        return [f"{name}: holds for all clusters{least}"]
    head = f"{name}: {found.status}, for {found.failing} of {found.clusters} clusters"
    more = found.failing - len(found.shortfalls)
    tail = [f"  ... and {more} more"] if more > 0 else []
    return [head, *(_shortfall(entry) for entry in found.shortfalls), *tail]


def _shortfall(entry: Shortfall) -> str:
    if entry.robots is None:
        robots = f"some {entry.size} robots"
    else:
        robots = "robots " + ", ".join(map(str, entry.robots))
    return f"  {robots}: {entry.status}, short by {-entry.margin:.4f} m"


def _method(found: CheckReport) -> str:
    if not found.every_cluster:
        return "More than 12 robots: bounded per cluster size; Lambda', Lambda'' are proven upper bounds."
    how = "exact" if found.exact else "proven upper bounds, not always attained"
    return f"All subsets of two or more robots; Lambda' and Lambda'' are {how}."


def _bounds(bounds: Bounds) -> Table:
    table = Table(title=f"Bounds on k at the best eps = {bounds.eps:.3g} m²", title_justify="left")
    for column in ("bound", "value", "consequence of a larger k"):
        table.add_column(column)
    table.add_row("K1", f"{bounds.k1.low:.4g} to {bounds.k1.high:.4g}", "no critical point off all obstacles")
    table.add_row("K21", f"at most {bounds.k21:.4g}", "clusters repel enough to turn (Lemma E.15)")
    table.add_row("K2", f"at most {bounds.k2:.4g}", "no minimum where robots are close (K22 corrected)")
    table.add_row("K3", f"at most {bounds.k3:.4g}", "no critical point near the outer boundary")
    table.add_row("K", f"{bounds.polar:.4g}", "the goal is the only minimum (Proposition 3.1)")
    table.add_row("N1", str(bounds.n1), "first part of Proposition D.2")
    table.add_row("N2", "infinite", "Proposition D.2 cannot hold where saddles exist")
    return table


def _verdict(found: CheckReport) -> list[str]:
    if found.unreachable:
        triples = "; ".join(", ".join(map(str, triple)) for triple in found.unreachable)
        return [
            f"UNREACHABLE by any controller: robots {triples} can never be in a line, so they cannot "
            "change their orientation, and start and goal differ in it."
        ]
    if found.bounds is None and found.assumption_1.status == found.assumption_2.status == "holds":
        return [
            "Arrival is not proven for any k: Proposition C.3 also needs goals and clusters well off the rim."
        ]
    if found.bounds is None:
        return ["Arrival is not proven for any k, since the assumptions are not shown."]
    reach = "is above it: guaranteed" if found.guaranteed else "is below it: not covered"
    return [
        f"Proven: for k > {found.bounds.polar:.4g} the goal is the only minimum and almost every start leads "
        f"there. k = {found.facts.k:.4g} {reach}.",
        "Not proven: that phi is Morse. Almost every start needs only that every other equilibrium has a "
        "direction of descent, which K2 gives.",
    ]


def _certificate(found: CheckReport) -> list[str]:
    stored = found.certificate
    if stored is None:
        return ["No certificate: `disknav certify` proves a k for these goals by computation."]
    if stored.refused is not None:
        return [f"Certificate refused: {stored.refused}"]
    if stored.k is None:
        return [f"{stored.file} proves nothing yet: repeat `disknav certify` to continue it."]
    use = "is covered" if found.facts.k >= stored.k else "is not covered"
    return [
        f"Certified by computation ({stored.file}): for every k >= {stored.k:.4g} the goal is the only "
        f"minimum and every other critical point has a direction of descent. k = {found.facts.k:.4g} {use}."
    ]


def _practice(found: CheckReport) -> list[str]:
    seen = found.practice
    if seen is None:
        return ["In practice: not tried with more than 32 robots."]
    own = f"arrives, nrl {seen.nrl:.2f}" if seen.arrived else _rest_text(seen.rest)
    lines = [
        f"In practice at k = {found.facts.k:.4g}, exact flow: the scenario's start {own}; "
        f"{seen.random_arrived} of {seen.random_starts} random starts arrive."
    ]
    if seen.searched:
        kinds = ", ".join(_counted(count, kind) for kind, count in sorted(seen.equilibria.items()))
        lines.append(f"Equilibria found besides the goal: {kinds or 'none'}; more may exist.")
    if seen.other_minima:
        lines.append(f"{seen.other_minima} of them are minima, where the fleet can come to rest. Raise k.")
    return lines


def _counted(count: int, kind: str) -> str:
    noun, _, rest = kind.partition(" ")
    plural = {"minimum": "minima"}.get(noun, f"{noun}s")
    return " ".join(filter(None, (str(count), noun if count == 1 else plural, rest)))


def _rest_text(kind: str | None) -> str:
    if kind is None:
        return "does NOT arrive"
    if kind.startswith("saddle"):
        return f"comes to rest at a {kind}, which any disturbance leaves (such starts have measure zero)"
    return f"does NOT arrive: it comes to rest at another {kind}"
