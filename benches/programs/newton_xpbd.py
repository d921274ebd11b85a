"""Times sweeps of the XPBD solver of the physics engine Newton, for `--bin sweeps`.

Needs the packages newton 1.8.0 and warp-lang 1.19.0. It works on one processor core, without a GPU.

The first line on standard input is a sheet in JSON: masses, positions, pins (with mass 0), ends, rest
lengths, stiffness and damping of springs. Each further line `SWEEPS STEPS` asks for so many steps of
so many sweeps from the start. The answer is the median time of a step in microseconds.
"""

import json
import os
import sys
import time

# The packages write to standard output; here that is for answers.
answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

import warp as wp  # noqa: E402

wp.set_device("cpu")

import newton  # noqa: E402  (after the device is set)


def build(sheet):
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -9.81))
    for mass, position in zip(sheet["mass_kg"], sheet["position_m"]):
        builder.add_particle(position, (0.0, 0.0, 0.0), mass, radius=0.0)
    for (i, j), k, c in zip(sheet["springs"], sheet["stiffness"], sheet["damping"]):
        builder.add_spring(i, j, k, c, 0.0)
    builder.spring_rest_length = sheet["rest_length_m"]
    return builder.finalize(device="cpu")


def main():
    sheet = json.loads(sys.stdin.readline())
    model = build(sheet)
    print(f"newton {newton.__version__}, warp-lang {wp.__version__}", file=answers, flush=True)
    for line in sys.stdin:
        sweeps, steps = map(int, line.split())
        solver = newton.solvers.SolverXPBD(model, iterations=sweeps)
        before, after, control = model.state(), model.state(), model.control()
        times = []
        for _ in range(steps):
            begin = time.perf_counter()
            solver.step(before, after, control, None, sheet["step_s"])
            times.append(time.perf_counter() - begin)
            before, after = after, before
        times.sort()
        print(1e6 * times[len(times) // 2], file=answers, flush=True)


main()
