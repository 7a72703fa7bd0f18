"""One run of the benchmark: all that chance decides, from a seed and an index alone."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from experiments.touch.motions import CONTACT_FREE, KINDS, PUSHED, drawn_motion
from experiments.touch.pushes import PushGenerator, TouchPush
from robot_model import Robot
from robot_sim.motions import Motion

TRIES = 200  # for a second push on another link of the sub-tree


@dataclass(frozen=True, eq=False)
class Case:
    """What the robot does and how it is pushed; a contact-free case has no pushes."""

    seed: int
    index: int
    kind: str  # of motion
    motion: Motion | None
    wait: float  # s of motion before the push
    pushes: tuple[TouchPush, ...]

    @property
    def base(self) -> str:
        return KINDS[self.kind].base

    @property
    def noise(self) -> int:
        """Seed of the errors of sensors and model."""
        return int(np.random.SeedSequence([self.seed, self.index, 3]).generate_state(1)[0])


def pushed_case(
    generator: PushGenerator, robot: Robot, seed: int, index: int, contacts: str = "one"
) -> Case:
    """Draw a run; the first push is the same however many contacts there are."""
    random = np.random.default_rng([seed, index])
    kind = str(random.choice(PUSHED, p=(0.28, 0.28, 0.28, 0.16)))
    motion, wait = drawn_motion(robot, kind, random), float(random.uniform(0.2, 0.8))
    base = KINDS[kind].base
    subtrees = generator.subtrees(base)
    chosen = int(random.choice(subtrees))
    first = generator.draw(random, chosen, base)
    pushes = [first]
    if contacts == "apart":
        other = int(random.choice([i for i in subtrees if i != chosen]))
        pushes.append(generator.draw(random, other, base))
    if contacts == "together":
        pushes.append(_beside(first, (generator.draw(random, chosen, base) for _ in range(TRIES))))
    if contacts != "one":  # so that both are there at one time
        pushes = [_like(push, first) for push in pushes]
    return Case(seed, index, kind, motion, wait, tuple(pushes))


def _beside(first: TouchPush, others: Iterable[TouchPush]) -> TouchPush:
    """Choose a push on another link, or where the sub-tree has no other, the last one."""
    other = first
    for other in others:
        if other.link != first.link:
            break
    return other


def _like(push: TouchPush, first: TouchPush) -> TouchPush:
    return TouchPush(push.link, push.point, push.force, first.kind, first.shape)


def contact_free_case(robot: Robot, seed: int, index: int) -> Case:
    """Draw a run without pushes; kinds of motion take turns."""
    random = np.random.default_rng([seed, index, 1])
    kind = CONTACT_FREE[index % len(CONTACT_FREE)]
    return Case(seed, index, kind, drawn_motion(robot, kind, random), 0.0, ())
