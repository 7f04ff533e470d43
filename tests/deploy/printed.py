"""What a terminal shows."""

from rich.console import Console, RenderableType


def printed(what: RenderableType) -> str:
    console = Console(width=200, no_color=True, force_terminal=False)
    with console.capture() as capture:
        console.print(what)
    return capture.get()
