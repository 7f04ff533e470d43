"""systemd: a unit each for router and world, a template for robots, a target for them all."""

from __future__ import annotations

from collections.abc import Sequence

from deploy.manifests.plan import KEYS, SCENARIO, Plan, join
from deploy.security.roster import ROUTER, WORLD

ETC = "/etc/disknav"  # the folder of a run lies in here
_HOMES = ("/home/", "/root/", "/run/user/")
_WATCHDOG = "WatchdogSec=10"  # the main loop tells every second that it goes round
_HARDENING = """\
# An account that exists while this runs; keys reach it as credentials, so their files can stay root's.
DynamicUser=yes
NoNewPrivileges=yes
CapabilityBoundingSet=
AmbientCapabilities=
ProtectSystem=strict
{home}
ProtectProc=invisible
ProcSubset=pid
ProtectClock=yes
ProtectHostname=yes
ProtectControlGroups=yes
ProtectKernelLogs=yes
ProtectKernelModules=yes
ProtectKernelTunables=yes
PrivateTmp=yes
PrivateDevices=yes
PrivateUsers=yes
RestrictAddressFamilies=AF_INET AF_INET6 AF_UNIX AF_NETLINK
RestrictNamespaces=yes
RestrictRealtime=yes
RestrictSUIDSGID=yes
LockPersonality=yes
MemoryDenyWriteExecute=yes
SystemCallArchitectures=native
SystemCallFilter=@system-service
SystemCallFilter=~@privileged @resources
SystemCallErrorNumber=EPERM
UMask=0077
MemoryMax=512M
TasksMax=64
"""


def systemd(plan: Plan) -> dict[str, str]:
    """Files by name."""
    name, folder = plan.name, f"{ETC}/{plan.name}"
    return {
        f"{name}.target": _target(plan, folder),
        f"{name}-{ROUTER}.service": _router(plan, folder),
        f"{name}-{WORLD}.service": _world(plan, folder),
        f"{name}-robot@.service": _robot(plan, folder),
        SCENARIO: plan.scenario,
    }


def _target(plan: Plan, folder: str) -> str:
    units = [f"{plan.name}-{role.replace('-', '@')}.service" for role in plan.robots]
    wanted = " ".join([f"{plan.name}-{ROUTER}.service", f"{plan.name}-{WORLD}.service", *units])
    return f"""\
# The whole run on one host, in this folder, as root:
#   mkdir -p {folder} && cp -r {KEYS} {SCENARIO} {folder}/
#   cp {plan.name}* /etc/systemd/system/ && systemctl daemon-reload && systemctl start {plan.name}.target
# On several, start the services that belong to each; only the keys of those are needed there.
[Unit]
Description=Fleet {plan.roster.run}
Wants={wanted}

[Install]
WantedBy=multi-user.target
"""


def _router(plan: Plan, folder: str) -> str:
    arguments = ["router", "--listen", plan.router, "--secure", "%d"]
    how = ["Restart=always", "RestartSec=1"]
    return _unit(plan, "Router of the fleet", _service(plan, folder, arguments, ROUTER, how))


def _world(plan: Plan, folder: str) -> str:
    arguments = join(WORLD, plan.router, "%d", plan, f"%d/{SCENARIO}")
    # A world that has gone cannot be replaced in the middle of a run; 130 is one that was asked to stop.
    how = ["Restart=no", "SuccessExitStatus=130", _WATCHDOG]
    service = _service(plan, folder, arguments, WORLD, how, more=(SCENARIO,))
    return _unit(plan, "World of the fleet", service, after=(ROUTER,))


def _robot(plan: Plan, folder: str) -> str:
    arguments = join("robot-%i", plan.router, "%d", plan, "")
    how = ["Restart=on-failure", "RestartSec=1", _WATCHDOG]
    service = _service(plan, folder, arguments, "robot-%i", how)
    return _unit(plan, "Robot %i of the fleet", service, after=(ROUTER,))


def _unit(plan: Plan, what: str, service: str, after: Sequence[str] = ()) -> str:
    order = "".join(f"After={plan.name}-{each}.service\n" for each in after)
    return f"""\
[Unit]
Description={what} {plan.roster.run}
Wants=network-online.target
After=network-online.target
{order}PartOf={plan.name}.target
StartLimitIntervalSec=60
StartLimitBurst=10

[Service]
Type=notify
TimeoutStartSec={plan.wait + 30:.0f}
{service}{_HARDENING.format(home=_home(plan))}"""


def _service(
    plan: Plan,
    folder: str,
    arguments: Sequence[str],
    role: str,
    how: Sequence[str],
    more: Sequence[str] = (),
) -> str:
    loads = [f"LoadCredential={name}:{folder}/{KEYS}/{name}" for name in plan.files(role)]
    loads += [f"LoadCredential={name}:{folder}/{name}" for name in more]
    lines = [f"ExecStart={' '.join([_quoted(plan.command), *arguments])}", *loads, *how, "TimeoutStopSec=5"]
    return "\n".join(lines) + "\n"


def _home(plan: Plan) -> str:
    """Homes are hidden, but for software that lies in one, whatever the modes of the folders above it."""
    there = [path for path in plan.software if path.startswith(_HOMES)]
    if not there:
        return "ProtectHome=yes"
    binds = [f"BindReadOnlyPaths={_quoted(path)}" for path in there]
    return "\n".join(["ProtectHome=tmpfs", *binds])


def _quoted(path: str) -> str:
    """A path as systemd reads one word."""
    escaped = path.replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%")
    return f'"{escaped}"' if escaped != path or set(path) & set(" :") else path
