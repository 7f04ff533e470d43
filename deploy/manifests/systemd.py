"""systemd: a unit each for router and world, a template for robots, a target for them all."""

from __future__ import annotations

from collections.abc import Sequence

from deploy.manifests.plan import KEYS, SCENARIO, Plan, join
from deploy.security.roster import ROUTER, WORLD

ETC = "/etc/disknav"  # the folder of a run lies in here
_HARDENING = """\
# An account that exists while this runs; keys reach it as credentials, so their files can stay root's.
DynamicUser=yes
NoNewPrivileges=yes
CapabilityBoundingSet=
AmbientCapabilities=
ProtectSystem=strict
ProtectHome={home}
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
    units = [f"{plan.name}-robot@{robot}.service" for robot in plan.roster.robots]
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
    return _unit(
        plan,
        "Router of the fleet",
        _service(plan, folder, arguments, ROUTER, restart="Restart=always\nRestartSec=1"),
    )


def _world(plan: Plan, folder: str) -> str:
    arguments = join(WORLD, plan.router, "%d", plan.mode, f"%d/{SCENARIO}")
    # A world that has gone cannot be replaced in the middle of a run.
    service = _service(plan, folder, arguments, WORLD, restart="Restart=no", more=(SCENARIO,))
    return _unit(plan, "World of the fleet", service, after=(ROUTER,))


def _robot(plan: Plan, folder: str) -> str:
    arguments = join("robot-%i", plan.router, "%d", plan.mode, "")
    service = _service(plan, folder, arguments, "robot-%i", restart="Restart=on-failure\nRestartSec=1")
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
Type=exec
{service}{_HARDENING.format(home="read-only" if plan.command.startswith(("/home/", "/root/")) else "yes")}"""


def _service(
    plan: Plan, folder: str, arguments: Sequence[str], role: str, *, restart: str, more: Sequence[str] = ()
) -> str:
    loads = [f"LoadCredential={name}:{folder}/{KEYS}/{name}" for name in plan.files(role)]
    loads += [f"LoadCredential={name}:{folder}/{name}" for name in more]
    lines = [f"ExecStart={' '.join([plan.command, *arguments])}", *loads, restart, "TimeoutStopSec=5"]
    return "\n".join(lines) + "\n"
