"""The processes of a soak run, and what may happen to them."""

import signal
import time
from collections import Counter
from collections.abc import Callable
from random import Random
from typing import Any

from bus import BusError, Node, RpcError
from bus.testing import Process, eventually, free_port
from bus.wiring import connect, disconnect

RECOVERY = 60.0  # s
RATE = 100.0  # Hz of each writer
STEADY = ("source0", "sink0")  # never touched, to see whether the others' fates reach them


class Stage:
    """A hub, writers, and readers of one writer each; the first pair is left alone."""

    def __init__(self, pairs: int, random: Random):
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.processes: dict[str, Process] = {}
        self._random = random
        self._start_all = ["hub", *(f"{kind}{k}" for k in range(pairs) for kind in KINDS)]
        self.unanswered: Counter[str] = Counter()
        self.extra: dict[str, str] = {}  # by sink, a source that it reads besides
        for name in self._start_all:
            self.start(name)
        self.node = Node("soak", connect=self.endpoint, signals=False)
        self.node.ready(timeout=RECOVERY)

    def start(self, name: str) -> None:
        """Start one."""
        if name == "hub":
            arguments = ("bus.hub", "--listen", self.endpoint, "--no-announce")
        else:
            kind, number = name.rstrip("0123456789"), name.lstrip("cdeiknorsu")
            settings = {"source": (f"rate={RATE}",), "sink": (f"rate={RATE}", "depth=64")}[kind]
            if kind == "sink":
                settings += (f"source=/source{number}/out:o",)
            sets = [text for setting in settings for text in ("--set", setting)]
            arguments = (f"tests.bus.{kind}", "--connect", self.endpoint, "--name", name, *sets)
        self.processes[name] = Process(*arguments)
        self.extra.pop(name, None)

    def act(self) -> str:
        """Let something happen; return what."""
        action = self._random.choices(list(ACTIONS), weights=[w for _, w in ACTIONS.values()])[0]
        ACTIONS[action][0](self)
        return action

    def report(self, sink: str, clear: bool = False) -> dict[str, Any] | None:
        """Return a reader's report; None when it does not answer."""
        try:
            return self.node.call(f"/{sink}/rpc:i", "report", {"clear": clear}, timeout=2.0)
        except RpcError:
            return None

    def recovered(self) -> float:
        """Wait until all are ready and every reader has fresh data; return how long it took [s]."""
        began = time.monotonic()
        eventually(self._ready, RECOVERY, "all to be ready")
        for sink in self.sinks:
            eventually(lambda sink=sink: self._well(sink), RECOVERY, f"fresh data on {sink}")
        return time.monotonic() - began

    @property
    def sinks(self) -> list[str]:
        """Names of the readers."""
        return [name for name in self.processes if name.startswith("sink")]

    def kill_one(self) -> None:
        name = self._victim()
        self.processes[name].kill()
        self.processes[name].clean_up()
        time.sleep(self._random.uniform(0.0, 1.0))
        self.start(name)

    def kill_hub(self) -> None:
        self.processes["hub"].kill()
        self.processes["hub"].clean_up()
        time.sleep(self._random.uniform(0.0, 2.0))
        self.start("hub")

    def end_one(self) -> None:
        name = self._victim()
        assert self.processes[name].stop(timeout=RECOVERY) == 0, self.processes[name].output
        self.processes[name].clean_up()
        self.start(name)

    def stop_one(self) -> None:
        name = self._random.choice([self._victim(), "hub"])
        self.processes[name].send(signal.SIGSTOP)
        time.sleep(self._random.uniform(0.1, 4.0))
        self.processes[name].send(signal.SIGCONT)

    def rewire(self) -> None:
        """Let a reader read the steady writer too, or no more."""
        sink = self._random.choice(self.sinks[1:])
        change, source = (disconnect if sink in self.extra else connect), "/source0/out:o"
        try:
            change(self.node, source, f"/{sink}/in:i")
        except BusError:  # its owner has just been restarted: it knows its own sources only
            self.extra.pop(sink, None)
            return
        if self.extra.pop(sink, None) is None:
            self.extra[sink] = source

    def ask(self) -> None:
        """Ask everybody many times."""
        for _ in range(50):
            for name in self.processes:
                eventually(lambda name=name: self._answers(name), RECOVERY, f"{name}'s answer")

    def close(self) -> list[str]:
        """End all; return who did not end as asked."""
        self.node.close()
        complaints = []
        for name, process in reversed(self.processes.items()):
            process.send(signal.SIGCONT)
            status = process.stop(timeout=RECOVERY)
            if status != 0:
                complaints.append(f"{name} ended with {status}: {process.output}")
            process.clean_up()
        return complaints

    def _victim(self) -> str:
        others = [name for name in self.processes if name not in (*STEADY, "hub")]
        return self._random.choice(others)

    def _answers(self, name: str) -> bool:
        """Whether it answers; a starved process is absent for a moment, which is counted."""
        try:
            return bool(self.node.call(f"/{name}/rpc:i", "status", timeout=5.0))
        except RpcError as error:
            self.unanswered[type(error).__name__] += 1
            return False

    def _ready(self) -> bool:
        """Whether all may be asked to end: signals that come before are Python's to handle."""
        for name, process in self.processes.items():
            ended = process.popen.poll()
            assert ended is None, f"{name} ended with {ended}: {process.output}"
        ready = {owner.pid for owner in self.node.directory.services()}
        return ready >= {process.pid for process in self.processes.values()}

    def _well(self, sink: str) -> bool:
        report = self.report(sink)
        return report is not None and report["is_fresh"]


KINDS = ("source", "sink")
ACTIONS: dict[str, tuple[Callable[[Stage], None], int]] = {
    "kill": (Stage.kill_one, 4),
    "end": (Stage.end_one, 2),
    "stop": (Stage.stop_one, 3),
    "kill the hub": (Stage.kill_hub, 1),
    "rewire": (Stage.rewire, 3),
    "ask": (Stage.ask, 2),
}
