#!/usr/bin/env python3
"""Implicit midpoint by Newton's method with SciPy: M (w - v) = h/2 f(x + h/2 w, w), x' = x + h w,
v' = 2 w - v. Directions of projected damping are those of the predicted middle x + h/2 v.

drape run hanging-textile-1e6 --method program:./implicit_midpoint.py --dt 0.01
"""

import sys

from drape_method import serve
from cloth import Cloth

try:
    import numpy as np
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu
except ImportError as missing:
    sys.exit(f"{missing}: this method needs SciPy (pip install scipy)")

np.seterr(all="ignore")  # a run that blows up is a result
RESIDUAL = 1e-13  # relative to the impulse of the step
ITERATIONS = 40
SMALLEST = 2.0**-12  # share of a Newton step


class ImplicitMidpoint(Cloth):
    hello = {
        "name": "implicit midpoint in Python",
        "order": 2,
        "class": "symplectic",
        "conserves": ["momentum", "angular momentum"],
        "implicit": True,
        "supports": Cloth.effects + Cloth.dampings,
    }

    def system(self, system, time):
        super().system(system, time)
        springs = np.array(self.springs, dtype=float).reshape(-1, 5)
        self.i, self.j = (springs[:, 0] / 3).astype(int), (springs[:, 1] / 3).astype(int)
        self.rest, self.k, self.c = springs[:, 2], springs[:, 3], springs[:, 4]
        self.m = np.array(self.mass)
        free = np.ones(len(self.mass), dtype=bool)
        free[self.pinned] = False
        self.free = np.repeat(free, 3)
        # The unknown of each coordinate, and the blocks (i, i), (j, j), (i, j), (j, i) of springs.
        axis = np.arange(3)
        pairs = [(self.i, self.i), (self.j, self.j), (self.i, self.j), (self.j, self.i)]
        shape = (len(springs), 3, 3)
        row = lambda a: np.broadcast_to(3 * a[:, None, None] + axis[:, None], shape).ravel()
        column = lambda a: np.broadcast_to(3 * a[:, None, None] + axis, shape).ravel()
        self.rows = np.concatenate([row(a) for a, _ in pairs] + [np.arange(3 * len(self.m))])
        self.columns = np.concatenate([column(b) for _, b in pairs] + [np.arange(3 * len(self.m))])

    def scatter(self, f):
        """Sums what springs do to their ends."""
        out = np.zeros((len(self.m), 3))
        np.add.at(out, self.i, -f)
        np.add.at(out, self.j, f)
        return out

    def directions(self, x):
        d = x[self.i] - x[self.j]
        length = np.linalg.norm(d, axis=1)
        sound = length > 1e-12 * self.rest
        over = np.where(sound, 1.0 / np.where(length > 0.0, length, 1.0), 0.0)
        return d, over

    def damping(self, ahead):
        """The block of each spring's damping: c I, or c u u^T."""
        if not self.projected:
            return self.c[:, None, None] * np.eye(3)
        d, over = self.directions(ahead)
        u = d * over[:, None]
        return self.c[:, None, None] * u[:, :, None] * u[:, None, :]

    def defect(self, w, x, v, h, c):
        """M (w - v) - h/2 f(x + h/2 w, w) of the free particles."""
        d, over = self.directions(x + 0.5 * h * w)
        f = d * (self.k * (1.0 - self.rest * over))[:, None]
        f += np.einsum("sab,sb->sa", c, w[self.i] - w[self.j])
        force = self.scatter(f) + self.m[:, None] * np.array(self.gravity)
        defect = self.m[:, None] * (w - v) - 0.5 * h * force
        scale = 0.5 * h * np.abs(f).max(initial=0.0)
        return defect.ravel() * self.free, scale

    def matrix(self, w, x, h, c):
        d, over = self.directions(x + 0.5 * h * w)
        u = d * over[:, None]
        across = (1.0 - self.rest * over)[:, None, None] * np.eye(3)
        along = (self.rest * over)[:, None, None] * u[:, :, None] * u[:, None, :]
        block = (0.25 * h * h * self.k[:, None, None] * (across + along) + 0.5 * h * c).ravel()
        values = np.concatenate([block, block, -block, -block, np.repeat(self.m, 3)])
        led = ~(self.free[self.rows] & self.free[self.columns])
        values[led] = np.where(self.rows[led] == self.columns[led], 1.0, 0.0)
        n = len(self.free)
        return coo_matrix((values, (self.rows, self.columns)), shape=(n, n)).tocsc()

    def step(self, x, v, pins, t, h):
        x, v = np.array(x).reshape(-1, 3), np.array(v).reshape(-1, 3)
        v[self.pinned] = (np.array(pins).reshape(-1, 3) - x[self.pinned]) / h
        c = self.damping(x + 0.5 * h * v)
        w, iterations, evaluations = v.copy(), 0, 1
        defect, scale = self.defect(w, x, v, h, c)
        gravity = 0.5 * h * self.m.max() * np.linalg.norm(self.gravity)
        while iterations < ITERATIONS:
            size = np.abs(defect).max(initial=0.0)
            if not size > RESIDUAL * max(scale, gravity):
                break
            turn = splu(self.matrix(w, x, h, c)).solve(-defect).reshape(-1, 3)
            share = 1.0
            while True:
                evaluations += 1
                trial, scale = self.defect(w + share * turn, x, v, h, c)
                if np.abs(trial).max() < size or share <= SMALLEST:
                    break
                share *= 0.5
            if np.abs(trial).max() >= size:
                break  # as small as round-off allows
            w, defect, iterations = w + share * turn, trial, iterations + 1
        x_new, v_new = x + h * w, 2.0 * w - v
        v_new[self.pinned] = v[self.pinned]
        costs = {"newton_iterations": iterations, "factorisations": iterations}
        converged = bool(np.abs(defect).max(initial=0.0) <= 1e-9 * max(scale, gravity))
        costs.update(force_evaluations=evaluations, converged=converged)
        return x_new.ravel().tolist(), v_new.ravel().tolist(), costs


serve(ImplicitMidpoint())
