"""`disknav calibrate`: drive a square with a base, and say what a scenario has to state of it."""

from __future__ import annotations

from typing import Annotated

import typer

from deploy.commands import options
from deploy.security.membership import Membership
from deploy.security.roster import OPERATOR
from protocol.errors import UsageError
from protocol.scenario.base import Base


def calibrate(
    scenario: options.Scenario,
    robot: Annotated[int, typer.Argument(metavar="ROBOT", help="Its id in the scenario.")],
    side: Annotated[
        float, typer.Option(min=0.2, help="Of the square, m; it begins ahead, to the left.")
    ] = 0.8,
    speed: Annotated[float, typer.Option(min=0.01, help="m/s.")] = 0.1,
    rate: Annotated[float, typer.Option(min=0.05, help="Of turns, rad/s.")] = 0.6,
    wait: Annotated[float, typer.Option(min=1.0, help="How long its messages may take to come, s.")] = 10.0,
    router: options.Router = None,
    setting: options.Settings = None,
    secure: options.Secure = None,
) -> None:
    """Drive a square with one robot's base, and say which bounds to state of it.

    It needs no fleet, and nobody else may drive this base. It looks at nothing on its way: keep the floor
    free.

    Example: disknav calibrate yard.toml 1 --side 1.0

    Exit status: 0 done, 2 invalid, 3 its messages do not come, or are others.
    """
    from deploy.calibrate.bounds import bounds, statements
    from deploy.calibrate.node import Calibration
    from deploy.calibrate.square import Driver, square
    from deploy.library.load import load
    from protocol.bus.drive import drive
    from protocol.bus.zenoh import ZenohBus

    options.refuse_bases(secure)
    loaded = load(scenario, setting or [], None)
    if robot not in loaded.ids:
        raise UsageError(f"{scenario} has no robot {robot}; there are {', '.join(map(str, loaded.ids))}")
    table = loaded.base_of(robot) or Base()
    membership = Membership()
    connection = membership.client(OPERATOR, (router or membership.default_router,))
    driver = Driver(table, robot, square(side, speed, rate))
    bus = ZenohBus(connection)
    drive(Calibration(bus, driver, wait), bus)
    found = bounds(driver.log)
    print(
        f"measured: poses at rest within {1e3 * found.noise_bound:.1f} mm and {found.heading:.3f} rad; sides "
        f"off by {100 * found.odometry:.1f} % by odometry, by {100 * found.error:.1f} % of the command;\n"
        f"late by {found.lag:.3f} s; odometry at least every {found.interval:.3f} s; left alone it brakes "
        f"after {found.timeout:.2f} s, by {found.acceleration:.2f} m/s^2\n"
        f"to state, with room for what one square does not show:\n\n{statements(found)}"
    )
