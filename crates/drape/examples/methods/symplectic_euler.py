#!/usr/bin/env python3
"""Symplectic Euler: v' = v + h f(x, v)/m, x' = x + h v'. Standard library only.

drape run hanging-textile-1e4 --method program:./symplectic_euler.py --dt 1e-3 --duration 0.1
"""

from drape_method import serve
from cloth import Cloth


class SymplecticEuler(Cloth):
    hello = {
        "name": "symplectic Euler in Python",
        "order": 1,
        "class": "symplectic",
        "conserves": ["momentum", "angular momentum"],
        "implicit": False,
        "supports": Cloth.effects + Cloth.dampings,
    }

    def step(self, x, v, pins, t, h):
        force = self.force(x, v)
        v = [w + h * f / self.mass[a // 3] for a, (w, f) in enumerate(zip(v, force))]
        for place, pin in enumerate(self.pinned):
            for a in range(3):
                v[3 * pin + a] = (pins[3 * place + a] - x[3 * pin + a]) / h
        x = [y + h * w for y, w in zip(x, v)]
        return x, v, {"force_evaluations": 1}


serve(SymplecticEuler())
