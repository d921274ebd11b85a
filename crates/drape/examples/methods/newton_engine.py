#!/usr/bin/env python3
"""Cloth solvers of the engine Newton (pip install newton; runs on a CPU) as methods of drape.

drape run hanging-textile-1e4 --method "program:./newton_engine.py semi-implicit" --dt 1e-3
drape run hanging-textile-1e4 --method "program:./newton_engine.py xpbd 20" --dt 0.01
drape run hanging-textile-1e4 --method "program:./newton_engine.py vbd 20" --dt 0.01

The number is that of the iterations of a step. The guide's page `engine` judges all three.

How its physics maps:

| drape | Newton |
|---|---|
| particle, mass | particle without radius, so that nothing collides |
| spring k, l, c with projected damping | spring ke, rest length, kd |
| spring c with full damping | force on the particles from outside, at the old time level |
| angles, air, contacts | nothing: refused |
| gravity | the gravity of the model |
| pin | a particle of mass 0, which moves with the velocity that leads it; `vbd` puts it at its
new place before the step |
| colours of particles (`vbd`) | no spring joins two of the same colour: Newton colours triangles only |
| a step | one call of the solver, without substeps |

Newton computes in single precision: 1e-7 of a metre, and 1e-7/h of a metre per second.
"""

import sys

from drape_method import serve
from cloth import Cloth

try:
    import newton
    import numpy as np
    import warp as wp
except ImportError as missing:
    sys.exit(f"{missing}: this method needs Newton (pip install newton)")


def coloured(count, springs):
    """Groups of particles of which no two share a spring."""
    near = [set() for _ in range(count)]
    for i, j, *_ in springs:
        near[i // 3].add(j // 3)
        near[j // 3].add(i // 3)
    colour = [-1] * count
    for i in range(count):
        taken = {colour[j] for j in near[i]}
        colour[i] = next(c for c in range(count + 1) if c not in taken)
    colour = np.array(colour)
    return [np.flatnonzero(colour == c) for c in range(colour.max() + 1)]


class Engine(Cloth):
    def __init__(self, solver, iterations):
        self.solver, self.iterations = solver, iterations
        implicit = solver != "semi-implicit"
        self.hello = {
            "name": f"{newton.__name__} {newton.__version__}, solver {solver}",
            "source": "the engine Newton, https://github.com/newton-physics/newton",
            "order": 1,
            "class": "dissipative" if implicit else "symplectic",
            "implicit": implicit,
            "supports": Cloth.effects + Cloth.dampings,
        }

    def system(self, system, time):
        super().system(system, time)
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
        pinned = set(self.pinned)
        for i, (x, m) in enumerate(zip(system["particles"]["position_m"], self.mass)):
            builder.add_particle(x, (0.0, 0.0, 0.0), 0.0 if i in pinned else m, radius=0.0)
        for i, j, _, k, c in self.springs:
            builder.add_spring(i // 3, j // 3, k, c if self.projected else 0.0, 0.0)
        if self.solver == "vbd":
            builder.set_coloring(coloured(len(self.mass), self.springs))
        self.model = builder.finalize(device="cpu")
        self.model.set_gravity(tuple(self.gravity))
        self.model.particle_max_velocity = 1e12
        self.model.particle_grid = None  # no particle meets another one
        if self.springs:
            rest = np.array([spring[2] for spring in self.springs], dtype=np.float32)
            self.model.spring_rest_length.assign(rest)
        if self.solver == "xpbd":
            self.engine = newton.solvers.SolverXPBD(self.model, iterations=self.iterations)
        elif self.solver == "vbd":
            self.engine = newton.solvers.SolverVBD(self.model, iterations=self.iterations)
        else:
            self.engine = newton.solvers.SolverSemiImplicit(self.model)
        ends = np.array([spring[:2] for spring in self.springs], dtype=int).reshape(-1, 2) // 3
        self.ends = ends[:, 0], ends[:, 1]
        self.damping = np.array([spring[4] for spring in self.springs]).reshape(-1, 1)
        self.states = self.model.state(), self.model.state()
        self.control = self.model.control()

    def full_damping(self, v):
        """What Newton has no spring for, N; nothing with projected damping."""
        force = np.zeros_like(v)
        if not self.projected:
            i, j = self.ends
            pull = self.damping * (v[i] - v[j])
            np.add.at(force, j, pull)
            np.subtract.at(force, i, pull)
        return force

    def step(self, x, v, pins, t, h):
        before, after = self.states
        x, v = np.array(x).reshape(-1, 3), np.array(v).reshape(-1, 3)
        if self.solver == "vbd":
            x[self.pinned] = np.array(pins).reshape(-1, 3)
        before.particle_q.assign(x.astype(np.float32))
        before.particle_qd.assign(v.astype(np.float32))
        before.particle_f.assign(self.full_damping(v).astype(np.float32))
        self.engine.step(before, after, self.control, None, h)
        x_new = after.particle_q.numpy().astype(float)
        v_new = after.particle_qd.numpy().astype(float)
        x_new[self.pinned] = np.array(pins).reshape(-1, 3)
        sweeps = 1 if self.solver == "semi-implicit" else self.iterations
        return x_new.ravel().tolist(), v_new.ravel().tolist(), {"force_evaluations": sweeps}


SOLVERS = ("semi-implicit", "xpbd", "vbd")
words = sys.argv[1:] or ["xpbd"]
if words[0] not in SOLVERS:
    sys.exit(f"solver {words[0]}; expected one of: {', '.join(SOLVERS)}")
wp.config.quiet = True
serve(Engine(words[0], int(words[1]) if len(words) > 1 else 20))
