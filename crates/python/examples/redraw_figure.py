"""Redraws a figure: iterations of conjugate gradients a step against the stiffness of the sheet.

    python redraw_figure.py OUT.png [RECORD]

Eberhardt, Etzmuß and Hauth expect the count to grow with the stiffness. Each point is a run of one
second made here. RECORD is results/cg-vs-stiffness.json: its points are drawn as circles.
"""

import json
import sys

import drape
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

STIFFNESSES = [1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8]
PRECONDITIONERS = ["none", "jacobi", "ic0"]


def sheet(stiffness: float) -> drape.Scene:
    """The hanging textile with another k/m, 1/s²."""
    system = json.loads(drape.Scene.load("hanging-textile-1e4").json)
    for spring in system["springs"]:
        spring["stiffness_n_per_m"] *= stiffness / 1e4
    return drape.Scene.parse(json.dumps(system), f"hanging-textile at {stiffness:g}")


def iterations(stiffness: float, preconditioner: str) -> float:
    """Iterations a step of plain IMEX Euler, h = 0.01 s."""
    settings = {"forcing_term": 0.05, "preconditioner": preconditioner,
                "start": "extrapolated", "norm": "euclid"}
    run = drape.run(sheet(stiffness), "imex-euler", dt=0.01, duration=1.0, settings=settings)
    return run.counts["cg_iterations"] / run.steps


def recorded(record: str, preconditioner: str) -> list[tuple[float, float]]:
    """The same from the record of the study."""
    with open(record, encoding="utf-8") as file:
        cells = json.load(file)["facts"]["cells"]
    wanted = {"series": "stiffness", "material": "fixed-k-over-m", "particles": 400,
              "variant": "plain", "preconditioner": preconditioner, "start": "extrapolated"}
    return [(cell["stiffness_over_mass_per_s2"], cell["cg_per_step"]) for cell in cells
            if all(cell[key] == value for key, value in wanted.items())]


def main() -> None:
    """Draws into the file that is named."""
    out, *record = sys.argv[1:]
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for preconditioner in PRECONDITIONERS:
        counts = [iterations(stiffness, preconditioner) for stiffness in STIFFNESSES]
        line, = axes.loglog(STIFFNESSES, counts, marker=".", label=preconditioner)
        for file in record:
            points = recorded(file, preconditioner)
            axes.loglog(*zip(*points), "o", mfc="none", ms=9, color=line.get_color())
            off = [a for a, (_, b) in zip(counts, points, strict=True) if a != b]
            print(preconditioner, "as recorded" if not off else f"differs: {off}")
    axes.set_xlabel("k/m, 1/s²")
    axes.set_ylabel("CG iterations a step")
    axes.set_title("IMEX Euler on the hanging textile, h = 0.01 s, ε = 0.05")
    axes.legend(title="preconditioner")
    figure.savefig(out, dpi=150)


main()
