"""Writes newton.json: trajectories of the physics engine Newton on a sheet of springs.

Needs the packages newton 1.8.0 and warp-lang 1.19.0, on a processor (no GPU):

    python newton_reference.py newton.json

The solvers work in single precision. All inputs are numbers of single precision, so that other
programs start from exactly the same ones.
"""

import json
import sys

import numpy as np
import warp as wp

wp.config.quiet = True
wp.set_device("cpu")

import newton  # noqa: E402  (after the device is set)

SIDE = 4
SPACING = 0.25
MASS = 0.25
STEP = 1.0 / 64.0
GRAVITY = (0.0, 0.0, -9.75)
RECORDED = (1, 4)


def particle(row, column):
    return row * SIDE + column


def frozen():
    """Positions, velocities and springs of the sheet; corners of one edge are pinned."""
    random = np.random.default_rng(5)
    x, v = [], []
    for row in range(SIDE):
        for column in range(SIDE):
            bump = random.integers(-64, 65, 3) / 2048.0
            x.append([column * SPACING + bump[0], -row * SPACING + bump[1], bump[2]])
            v.append(list(random.integers(-512, 513, 3) / 1024.0))
    pins = [particle(0, 0), particle(0, SIDE - 1)]
    for pin in pins:
        v[pin] = [0.0, 0.0, 0.0]
    springs = []
    for row in range(SIDE):
        for column in range(SIDE):
            for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
                to = (row + down, column + right)
                if to[0] < SIDE and 0 <= to[1] < SIDE:
                    springs.append([particle(row, column), particle(*to)])
    return x, v, pins, springs


def colours(springs):
    """Each particle takes the least colour that no earlier neighbour has."""
    of = []
    for i in range(SIDE * SIDE):
        taken = {of[min(a, b)] for a, b in springs if max(a, b) == i}
        of.append(next(c for c in range(len(taken) + 1) if c not in taken))
    return [[i for i, c in enumerate(of) if c == colour] for colour in range(max(of) + 1)]


def run(case):
    """Positions after the recorded numbers of steps."""
    x, v, pins, springs = frozen()
    builder = newton.ModelBuilder(gravity=GRAVITY)
    for i, (position, velocity) in enumerate(zip(x, v)):
        builder.add_particle(position, velocity, 0.0 if i in pins else MASS, radius=0.0)
    for i, j in springs:
        builder.add_spring(i, j, case["stiffness_n_per_m"], case["damping_n_s_per_m"], 0.0)
    builder.spring_rest_length = list(case["rest_length_m"])
    if case["colours"]:
        builder.set_coloring([np.array(colour) for colour in case["colours"]])
    model = builder.finalize(device="cpu")
    if case["solver"] == "vbd":
        solver = newton.solvers.SolverVBD(
            model, iterations=case["iterations"], enable_fast_math=False
        )
    else:
        solver = newton.solvers.SolverXPBD(model, iterations=case["iterations"])
    before, after, control = model.state(), model.state(), model.control()
    found = {}
    for step in range(1, max(RECORDED) + 1):
        solver.step(before, after, control, None, STEP)
        before, after = after, before
        if step in RECORDED:
            # The shortest text of a number of single precision.
            rows = before.particle_q.numpy()
            found[str(step)] = [[float(np.format_float_scientific(c)) for c in row] for row in rows]
    return found


def main():
    x, v, pins, springs = frozen()
    at = np.array(x)
    lengths = [float(np.linalg.norm(at[i] - at[j])) for i, j in springs]

    def rest(factor):
        return [float(np.float32(round(factor * length * 1024) / 1024)) for length in lengths]

    greedy = colours(springs)
    cases = [
        # Every spring stays stretched.
        dict(name="stretched", solver="vbd", iterations=2, rest=0.5, k=32.0, c=0.0, colours=greedy),
        dict(
            name="other colours",
            solver="vbd",
            iterations=2,
            rest=0.5,
            k=32.0,
            c=0.0,
            colours=greedy[::-1],
        ),
        # Some springs are compressed.
        dict(name="compressed", solver="vbd", iterations=5, rest=1.25, k=256.0, c=0.0, colours=greedy),
        dict(name="damped", solver="vbd", iterations=5, rest=0.5, k=32.0, c=2.0, colours=greedy),
        dict(name="net", solver="xpbd", iterations=3, rest=1.0, k=32.0, c=0.25, colours=[]),
    ]
    out = {
        "package": f"newton {newton.__version__}, warp-lang {wp.__version__}",
        "step_s": STEP,
        "gravity_m_s2": GRAVITY,
        "mass_kg": MASS,
        "position_m": x,
        "velocity_m_s": v,
        "pins": pins,
        "springs": springs,
        "cases": [],
    }
    for case in cases:
        full = {
            "name": case["name"],
            "solver": case["solver"],
            "iterations": case["iterations"],
            "rest_length_m": rest(case["rest"]),
            "stiffness_n_per_m": case["k"],
            "damping_n_s_per_m": case["c"],
            "colours": case["colours"],
        }
        full["position_after_m"] = run(full)
        out["cases"].append(full)
    # One line for each key and case.
    lines = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in out.items() if key != "cases"]
    lines.append('"cases": [\n' + ",\n".join(json.dumps(case) for case in out["cases"]) + "\n]")
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write("{\n" + ",\n".join(lines) + "\n}\n")


main()
