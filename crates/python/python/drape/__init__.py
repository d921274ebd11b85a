"""Time integrators for mass-spring cloth, compared on one and the same cloth."""

from ._drape import (
    Comparison,
    Error,
    Method,
    Run,
    Scene,
    Setting,
    __version__,
    compare,
    methods,
    run,
    scenes,
)

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
