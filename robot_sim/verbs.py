"""What one can ask of the plant over RPC."""

from typing import Any

import numpy as np

from bus import Node, Pending
from robot_model import ports
from robot_sim.config import SimConfig
from robot_sim.plant import TICK, Base
from robot_sim.simulation import SLOW, Simulation
from robot_sim.support import announce_support

SUPPORT: dict[Base, str] = {"free": "floor", "fixed": "pole"}
MOST_STEPS = 100_000  # ticks of one request
LONGEST_SLOW = 60.0  # s of one request
CHANGEABLE = ("profile", "speed")


class Verbs:
    """The verbs of ``/<robot>/sim/rpc:i``, also on the service's own RPC port."""

    def __init__(self, node: Node, config: SimConfig, simulation: Simulation):
        self._node = node
        self._config = config
        self._simulation = simulation
        self._plant = simulation.plant
        verbs = ("push", "release", "reset", "pause", "resume", "step", "base", "motion")
        names = (*verbs, "slow_down", "scenario", "profile", "status")
        handlers = {verb: getattr(self, verb) for verb in names}
        node.rpc(ports.sim_rpc(simulation.plant.robot), handlers)
        for verb, handler in handlers.items():
            node.verb(verb, handler)
        node.parameters.on_change(self._change)

    def push(
        self,
        link: str,
        force: list[float],
        point: list[float] | None = None,
        frame: str = "link",
        profile: str = "hold",
        duration: float | None = None,
    ) -> dict[str, int]:
        """Push a link [N, m in its frame, s]; profile hold, ramp or half_sine."""
        if self._plant.fallen:
            raise RuntimeError("the robot has fallen; reset it first")
        point = [0.0, 0.0, 0.0] if point is None else point
        where, what = np.array(point, dtype=float), np.array(force, dtype=float)
        push_id = self._plant.push(link, where, what, frame, profile, duration)
        return {"push_id": push_id, "start_stamp": self._plant.time + TICK}

    def release(self, push_id: int | None = None) -> dict[str, list[int]]:
        """End one push, or all."""
        return {"released": self._plant.release(push_id)}

    def reset(self) -> dict[str, int]:
        """Go back to the start: home posture, time 0, no pushes."""
        self._simulation.reset()
        return {"time": self._plant.time}

    def pause(self) -> dict[str, int]:
        """Stop the simulated time."""
        self._simulation.pause()
        return {"time": self._plant.time}

    def resume(self) -> dict[str, int]:
        """Let the simulated time run again."""
        self._simulation.resume()
        return {"time": self._plant.time}

    def slow_down(self, seconds: float, speed: float = SLOW) -> dict[str, float]:
        """Go slower for some wall time [s], so that others have the processors."""
        if not 0.0 < seconds <= LONGEST_SLOW or not 0.0 < speed <= 1.0:
            raise ValueError(
                f"expected at most {LONGEST_SLOW:g} s and a speed of at most 1,"
                f" got {seconds!r} s and {speed!r}"
            )
        self._simulation.slow_down(speed, seconds)
        return {"seconds": seconds, "speed": speed}

    def step(self, ticks: int = 1) -> Pending:
        """Advance a paused plant by some ticks of 1 ms; answers when they are done."""
        if not isinstance(ticks, int) or not 1 <= ticks <= MOST_STEPS:
            raise ValueError(f"ticks must be a whole number from 1 to {MOST_STEPS}, got {ticks!r}")
        if not self._simulation.paused:
            raise RuntimeError("the plant runs; pause it before stepping")
        return self._simulation.step(ticks)

    def base(self, mode: Base) -> Pending:
        """Put the robot on the pole (fixed) or on the floor (free), and tell the services."""
        if mode not in SUPPORT:
            raise ValueError(f"mode must be one of {', '.join(SUPPORT)}, got {mode!r}")
        self._simulation.change_base(mode)
        return announce_support(self._node, self._config.robot, SUPPORT[mode], {"base": mode})

    def motion(self, name: str = "stop") -> dict[str, Any]:
        """Start a motion of the scenario by name, or stop the present one."""
        scenario = self._simulation.player.scenario
        self._plant.motion(None if name == "stop" else scenario.motion(name))
        return {"motion": name, "known": sorted(scenario.motions)}

    def scenario(self, name: str) -> dict[str, str]:
        """Begin a scenario, by name or file, now; what is pushed already stays pushed."""
        self._simulation.play(name)
        return {"scenario": name}

    def profile(self, name: str) -> dict[str, str]:
        """Change the noise profile of the sensors."""
        self._plant.profile(name)
        return {"profile": self._plant.profile_name}

    def status(self) -> dict[str, Any]:
        """State of the simulated robot and its time."""
        plant, simulation = self._plant, self._simulation
        return {
            **self._node.status(),
            "clock": simulation.state,
            "time": plant.time,
            "base": plant.base_mode,
            "profile": plant.profile_name,
            "scenario": simulation.scenario,
            "motion": plant.motion_name,
            "motions": sorted(simulation.player.scenario.motions),
            "fallen": plant.fallen,
            "pushes": plant.pushes,
            "ticks": simulation.ticks,
            "slipped_ticks": simulation.slipped,
            "refused_commands": simulation.refused,
            "waiting_for": simulation.waiting_for,
        }

    def _change(self, old: SimConfig, new: SimConfig) -> None:
        changed = [key for key in type(new).model_fields if getattr(old, key) != getattr(new, key)]
        if fixed := [key for key in changed if key not in CHANGEABLE]:
            raise ValueError(
                f"{', '.join(fixed)}: only {' and '.join(CHANGEABLE)} can change while the plant"
                " runs; the verbs base, motion, pause, resume and reset do the rest"
            )
        if "profile" in changed:
            self._plant.profile(new.profile)
        self._simulation.set_speed(new.speed)
