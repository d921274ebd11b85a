"""The compiled part of the package `drape`. Numbers are in SI units."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict, final, type_check_only

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Comparison",
    "Error",
    "Method",
    "Run",
    "Scene",
    "Setting",
    "__version__",
    "compare",
    "methods",
    "run",
    "scenes",
]

__version__: str

class Error(Exception):
    """The exception for what drape refuses, with the sentence that the command prints."""

@final
class Setting:
    """A setting of a method."""

    @property
    def key(self) -> str: ...
    @property
    def default(self) -> str: ...
    @property
    def values(self) -> str:
        """The allowed values, in words."""
    @property
    def help(self) -> str: ...

@final
class Method:
    """A time integrator."""

    @property
    def id(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def source(self) -> str:
        """Where it was published."""
    @property
    def order(self) -> int:
        """Order of accuracy."""
    @property
    def stability(self) -> Literal["dissipative", "symplectic"]:
        """The rule for its energy: it must not rise (dissipative), or not drift (symplectic)."""
    @property
    def theory(self) -> str:
        """Its stability by theory, in words."""
    @property
    def supports(self) -> dict[str, str]:
        """How it treats each effect of a scene."""
    @property
    def settings(self) -> list[Setting]: ...

def methods() -> list[Method]:
    """All methods, in the order in which they build on each other."""

def scenes() -> list[str]:
    """Names of the bundled scenes."""

@final
class Scene:
    """A cloth at its start, with everything that acts on it."""

    @staticmethod
    def load(scene: str) -> Scene:
        """A bundled scene by its name, a study's start `STUDY/NAME`, or a scene or frozen system
        from a file.

        Raises `Error`, which names the file, the key and the values that are allowed there.
        """
    @staticmethod
    def parse(text: str, name: str = "scene") -> Scene:
        """A scene or frozen system from JSON text; messages call it `name`. Raises `Error`."""
    @property
    def name(self) -> str: ...
    @property
    def particles(self) -> int: ...
    @property
    def springs(self) -> int: ...
    @property
    def dt(self) -> float | None:
        """The step that the scene suggests, s; None for a frozen system."""
    @property
    def duration(self) -> float | None:
        """The time that the scene suggests, s; None for a frozen system."""
    @property
    def masses(self) -> NDArray[np.float64]:
        """Masses, kg: (particles,)."""
    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions at the start, m: (particles, 3)."""
    @property
    def triangles(self) -> NDArray[np.uint32]:
        """Indices of particles: (triangles, 3)."""
    @property
    def pins(self) -> list[int]:
        """Indices of the pinned particles."""
    @property
    def json(self) -> str:
        """The discretised system, as `drape system` prints it."""

@final
class Run:
    """A run: the record that `drape run --out` writes, and the positions over time."""

    @property
    def scene(self) -> str: ...
    @property
    def method(self) -> str:
        """Id of the method."""
    @property
    def settings(self) -> dict[str, str]:
        """Every setting with the value that was used."""
    @property
    def dt(self) -> float:
        """The step, s."""
    @property
    def steps(self) -> int:
        """Steps that were completed."""
    @property
    def ending(self) -> Literal["completed", "diverged"]:
        """How the run ended. Divergence is a result, not an exception."""
    @property
    def verdict(
        self,
    ) -> Literal["stable", "locked", "gained energy", "diverged", "could not tell"]: ...
    @property
    def reason(self) -> str:
        """The reason for the verdict, in a sentence."""
    @property
    def share(self) -> float | None:
        """Share of the motion that the run kept; None where nothing was measured."""
    @property
    def expected_share(self) -> float | None:
        """The share that theory predicted before the run; None where it predicts nothing."""
    @property
    def spin_share(self) -> float | None:
        """Share of its angular momentum about the centre of mass that a free, spinning cloth has
        at the end; None where it does not spin, or where a torque may act on it."""
    @property
    def warnings(self) -> list[str]: ...
    @property
    def counts(self) -> dict[str, int]:
        """Iterations, factorisations, matrix products and force evaluations of the whole run."""
    @property
    def seconds(self) -> float:
        """Wall time of the steps, s."""
    @property
    def times(self) -> NDArray[np.float64]:
        """Times of `positions`, s, the start first: (samples,)."""
    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions over time, m: (samples, particles, 3)."""
    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities at the end, m/s: (particles, 3)."""
    @property
    def energy_times(self) -> NDArray[np.float64]:
        """Times of `energies` and momenta, s: (samples,), at most about 1000."""
    @property
    def energies(self) -> dict[str, NDArray[np.float64]]:
        """Energies by effect, with `kinetic` and `total`, J: each (samples,)."""
    @property
    def momenta(self) -> NDArray[np.float64]:
        """Linear momentum, kg m/s: (samples, 3)."""
    @property
    def angular_momenta(self) -> NDArray[np.float64]:
        """Angular momentum about the origin, kg m²/s: (samples, 3)."""
    @property
    def json(self) -> str:
        """The record, as `drape run --out` writes it."""

def run(
    scene: Scene,
    method: str,
    *,
    dt: float | None = None,
    duration: float | None = None,
    settings: Mapping[str, object] | None = None,
    threads: int = 1,
    every: int | None = None,
) -> Run:
    """Runs a scene with a method, as `drape run` does. The result has the same bits.

    `method` is an id, with settings after a colon or in `settings`; `program:COMMAND` runs a
    program of your own. `dt` and `duration`, s, come from the scene where they are not given. The
    run keeps positions at the start, after every `every` steps, and at the end. Without `every` it
    keeps them at about 1000 times at most.

    Raises `Error` when the scene, the method or a number is refused. Ctrl-C ends the run. With
    several threads, it takes effect only when the run ends by itself.
    """

@type_check_only
class Take(TypedDict):
    """The advised run."""

    method: str
    dt: float
    steps_per_frame: int
    error: float | None
    seconds_per_frame: float

@final
class Comparison:
    """The result of a comparison."""

    @property
    def advice(self) -> list[str]:
        """The advice, at most twelve lines."""
    @property
    def take(self) -> Take | None:
        """The advised run; None where no run met the target."""
    @property
    def table(self) -> dict[str, Any]:
        """Columns of the same length, one entry a run; `pandas.DataFrame(comparison.table)`.

        `form`, `method`, `verdict`: text. `dt` (s), `error` (m), `kept` (share of the motion),
        `seconds_per_frame` (s): numbers, NaN where unknown. `steps_per_frame`, `meets_target`.
        """
    @property
    def has_reference(self) -> bool:
        """Whether errors are measured against a true motion, not against half the steps."""
    @property
    def json(self) -> str:
        """The facts of the record, as in `compare.json`."""

def compare(
    scene: Scene,
    methods: Sequence[str] | None = None,
    *,
    metric: Literal["shape", "trajectory"] = "shape",
    target: float | None = None,
    frame: float = ...,
    budget: float = 60.0,
    duration: float | None = None,
    seed: int = 20,
    exhaustive: bool = False,
) -> Comparison:
    """Compares methods on a scene and advises one, as `drape compare` does.

    `methods`: ids, with settings after a colon; all methods if None. `target`: greatest error, m; a
    hundredth of the cloth's size if None. `frame`: length of a frame, s; 1/60 by default.
    `budget`: wall time, s.

    Raises `Error` when the scene, a method or an option is refused.
    """
