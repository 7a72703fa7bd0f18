"""``wrenchbus play`` and ``replay``: a recording on the bus, or in the place of a robot."""

import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.errors import UsageError
from deploy.options import Connection, Seconds, with_connection
from deploy.output import print_line
from deploy.verbs.start import Base, headless, launch, tell

if TYPE_CHECKING:
    from bus import Node
    from bus.recording.playback import Playback
    from bus.recording.player import Player
    from deploy.launcher.launcher import Launcher

File = Annotated[Path, typer.Argument(metavar="FILE", help="Recording, as walk.mcap.")]
Rate = Annotated[float, typer.Option(min=0.01, max=100.0, help="Speed; 1 is as it was.")]
Loop = Annotated[bool, typer.Option("--loop", help="Begin again at the end.")]
From = Annotated[float, typer.Option("--from", min=0.0, metavar="T", help="Begin there [s].")]
To = Annotated[float | None, typer.Option("--to", min=0.0, metavar="T", help="End there [s].")]


@with_connection
def play(
    connection: Connection,
    file: File,
    ports: Annotated[
        list[str] | None,
        typer.Argument(metavar="[PORT]...", help="Ports, or patterns; default: all outputs."),
    ] = None,
    rate: Rate = 1.0,
    loop: Loop = False,
    begin: From = 0.0,
    end: To = None,
    prefix: Annotated[str, typer.Option(metavar="P", help="Before all names, as /log.")] = "",
    paused: Annotated[bool, typer.Option("--paused", help="Wait for a key or resume.")] = False,
    stay: Annotated[bool, typer.Option("--stay", help="Stand still at the end.")] = False,
) -> None:
    """Write a recording's messages to the bus, with its clock, as they were sent.

    Keys: space pauses, s steps 10 ms, the arrows move by 5 s and change the speed, q ends.
    Others ask on /player/rpc:i: pause, resume, step, seek, rate, status.
    """
    from bus import Node
    from bus.recording import Recording
    from bus.recording.playback import Playback, select_ports
    from bus.recording.player import Player

    recording = Recording(file)
    chosen = select_ports(recording, ports or ())
    player = Player(recording, chosen, rate, loop, begin, end, paused=True)
    with Node(
        "player",
        connect=connection.connect,
        listen=connection.listen,
        zenoh_config=connection.config,
        namespace=connection.namespace,
        insecure=connection.insecure,
    ) as node:
        playback = Playback(node, player, chosen, prefix)
        node.ready()
        if not paused:
            player.resume()
        _run(node, playback, player, stay)
    player.close()
    print_line(f"played {player.played} messages of {len(chosen)} ports")


def _run(node: "Node", playback: "Playback", player: "Player", stay: bool) -> None:
    from deploy.playing import Controls
    from deploy.terminal import Keyboard, clear

    with Keyboard() as keyboard:
        controls = Controls(player, keyboard)
        while node.running and not controls.quit and (stay or not player.ended):
            playback.spin()
            controls.spin()
    clear()


def replay(
    file: File,
    robot: Annotated[
        str | None, typer.Option(help="Description, by name or file; default: as recorded.")
    ] = None,
    base: Annotated[Base, typer.Option(help="Free on the floor, or fixed on a pole.")] = Base.free,
    rate: Rate = 1.0,
    loop: Loop = False,
    begin: From = 0.0,
    end: To = None,
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="Each frame waits for every service.")
    ] = False,
    seconds: Seconds = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Open no page.")] = False,
) -> None:
    """Start all services on a recording's raw frames, and open the page.

    The services cannot tell it from the robot; commands go nowhere. With --lockstep every
    run gives the same estimates, bit by bit.
    """
    from deploy.demo import SUPPORT
    from deploy.replay import replay_application

    if end is not None and end <= begin:
        raise UsageError(f"--to: expected more than --from ({begin:g} s), got {end:g} s")
    part = {"rate": rate, "loop": loop, "begin": begin} | ({} if end is None else {"end": end})
    application = replay_application(file, robot, SUPPORT[base.value], lockstep, part)

    def welcome(launcher: "Launcher") -> None:
        tell(launcher)
        print_line("player:  wrenchbus rpc /player/rpc:i pause, resume, step, seek time=SECONDS")
        if not (no_browser or headless()):
            webbrowser.open(launcher.dashboard_url)

    launch(application, "localhost", seconds, welcome)
