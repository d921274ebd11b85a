"""The forces that most methods need: linear springs, gravity and pins. Standard library only."""


class Cloth:
    """Linear springs, gravity and pins: the force of the effects that most methods need."""

    effects = ["tension", "shear", "bending", "gravity", "pins", "moving pins"]
    dampings = ["full damping", "projected damping"]

    def system(self, system, _time):
        self.mass = system["particles"]["mass_kg"]
        self.springs = [
            (3 * s["i"], 3 * s["j"], s["rest_length_m"], s["stiffness_n_per_m"], s["damping_n_s_per_m"])
            for s in system["springs"]
        ]
        self.projected = system["damping"] == "projected"
        self.pinned = [pin["particle"] for pin in system["pins"]]
        self.gravity = system["effects"].get("gravity", {}).get("m_s2", [0.0, 0.0, 0.0])

    def force(self, x, v):
        """The force on all particles, N."""
        f = [m * g for m in self.mass for g in self.gravity]
        for i, j, rest, k, c in self.springs:
            d = [x[i] - x[j], x[i + 1] - x[j + 1], x[i + 2] - x[j + 2]]
            w = [v[i] - v[j], v[i + 1] - v[j + 1], v[i + 2] - v[j + 2]]
            length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) ** 0.5
            over = 1.0 / length if length > 1e-12 * rest and length > 0.0 else 0.0
            pull = k * (1.0 - rest * over)
            if self.projected:
                pull += c * (d[0] * w[0] + d[1] * w[1] + d[2] * w[2]) * over * over
                w = [0.0, 0.0, 0.0]
            for a in range(3):
                part = pull * d[a] + c * w[a]
                f[i + a] -= part
                f[j + a] += part
        return f
