"""Checks the package `drape`: check.py DRAPE, where DRAPE is the command of the same build."""

import json
import math
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np

import drape

COMMAND = sys.argv[1]
HERE = pathlib.Path(tempfile.mkdtemp())


def command(*words, code=0):
    """The output of the command on standard error."""
    done = subprocess.run([COMMAND, *words], cwd=HERE, capture_output=True, text=True)
    assert done.returncode == code, (words, done.returncode, done.stderr)
    return done.stderr


def record(scene, method, *more):
    command("run", scene, "--method", method, "--out", "run.json", *more)
    file = HERE / "run.json"
    told = json.loads(file.read_text())
    file.unlink()
    return told


def refuses(call, *parts):
    """The sentence with which a call is refused."""
    try:
        call()
    except drape.Error as error:
        assert all(part in str(error) for part in parts), (str(error), parts)
        return str(error)
    raise AssertionError(f"not refused: {parts}")


def without_clocks(run):
    run = json.loads(json.dumps(run))
    for key in ("seconds", "prepare_seconds"):
        run["totals"][key] = 0
    return run


def methods_and_scenes():
    ids = [method.id for method in drape.methods()]
    assert len(ids) == len(set(ids)) >= 30 and "imex-euler" in ids, ids
    method = next(method for method in drape.methods() if method.id == "imex-euler")
    assert method.order == 1 and method.stability == "dissipative" and method.theory
    assert method.supports["tension"] == "implicit", method.supports
    assert any(s.key == "forcing_term" and s.values and s.help for s in method.settings)
    assert "hanging-textile-1e4" in drape.scenes()


def scene_as_arrays():
    scene = drape.Scene.load("hanging-textile-1e4")
    assert (scene.particles, scene.positions.shape, scene.masses.shape) == (400, (400, 3), (400,))
    assert scene.positions.dtype == np.float64 and scene.triangles.dtype == np.uint32
    assert scene.triangles.shape == (2 * 19 * 19, 3) and scene.triangles.max() == 399
    assert len(scene.pins) == 2 and scene.dt == 0.01
    again = drape.Scene.parse(scene.json, "again")
    assert (again.positions == scene.positions).all() and again.springs == scene.springs
    assert again.dt is None
    start = drape.Scene.load("energy/sphere-1e4 damped")
    assert start.particles > 100


def runs_have_the_bits_of_the_command():
    cases = [
        ("hanging-textile-1e4", "imex-euler:forcing_term=0.05", {}, 1),
        ("square-table-1e4", "imex-updated", {}, 1),
        ("hanging-textile-1e4", "leapfrog", {"dt": 0.001, "duration": 0.2501}, 1),
        ("hanging-wool", "imex-euler", {"dt": 0.01}, 1),
        ("hanging-textile-1e4", "backward-euler", {"duration": 0.1}, 2),
    ]
    for name, method, time, threads in cases:
        words = [word for key, value in time.items() for word in (f"--{key}", str(value))]
        told = record(name, method, "--threads", str(threads), *words)
        run = drape.run(drape.Scene.load(name), method, threads=threads, **time)
        assert without_clocks(json.loads(run.json)) == without_clocks(told), (name, method)
        assert run.positions[-1].tolist() == told["final"]["position_m"], (name, method)
        assert run.velocities.tolist() == told["final"]["velocity_m_s"]
        assert run.times[-1] == told["final"]["time_s"] and run.times[0] == 0
        series = told["series"]
        for effect in series[0]["energy_j"]:
            energies = [sample["energy_j"][effect] for sample in series]
            assert run.energies[effect].tolist() == energies, effect
        assert run.energy_times.tolist() == [sample["time_s"] for sample in series]
        assert run.momenta.tolist() == [sample["momentum"] for sample in series]
        assert all(run.counts[key] == told["totals"][key] for key in run.counts)
        assert run.verdict.replace(" ", "_") == told["verdict"]["kind"], run.verdict
        assert run.reason == told["verdict"]["reason"]
        assert run.settings == told["settings"] and run.dt == told["dt_s"]
    # A locked cloth gets the warning that the command prints.
    said = command("run", "hanging-wool", "--method", "imex-euler", "--dt", "0.01")
    run = drape.run(drape.Scene.load("hanging-wool"), "imex-euler", dt=0.01)
    assert run.verdict == "locked" and run.share < 0.5 and run.warnings[0] in said


def positions_over_time():
    scene = drape.Scene.load("hanging-textile-1e4")
    run = drape.run(scene, "imex-euler", dt=0.01, duration=0.255, every=7)
    assert run.times.tolist() == [0, 0.07, 0.14, 0.21, 0.255], run.times
    assert run.positions.shape == (5, 400, 3) and run.positions.flags.c_contiguous
    assert (run.positions[0] == scene.positions).all()
    shorter = drape.run(scene, "imex-euler", dt=0.01, duration=0.14)
    assert (run.positions[2] == shorter.positions[-1]).all()
    assert (run.positions[:, scene.pins] == scene.positions[scene.pins]).all()
    # Nothing is copied when Python asks again.
    assert run.positions is run.positions and not run.positions.flags.owndata
    many = drape.run(scene, "symplectic-euler", dt=1e-4, duration=0.25)
    assert many.positions.shape[0] == many.times.size == 835 and many.steps == 2500
    with_settings = drape.run(scene, "imex-euler", dt=0.01, duration=0.05,
                              settings={"forcing_term": 0.05, "start": "last"})
    assert with_settings.settings["start"] == "last"


def faults_are_exceptions_with_the_sentence_of_the_command():
    (HERE / "broken.json").write_text('{ "format": "drape-scene/1", "cloth": 3 }')
    broken = str(HERE / "broken.json")
    sheet = drape.Scene.load("hanging-textile-1e4")
    for words, call in [
        (["no-such-scene", "imex-euler"], lambda: drape.Scene.load("no-such-scene")),
        ([broken, "imex-euler"], lambda: drape.Scene.load(broken)),
        (["hanging-textile-1e4", "no-such-method"], lambda: drape.run(sheet, "no-such-method")),
        (["hanging-textile-1e4", "imex-euler:forcing_term=7"],
         lambda: drape.run(sheet, "imex-euler", settings={"forcing_term": 7})),
        (["hanging-textile-1e4", "imex-euler", "--dt", "-1"],
         lambda: drape.run(sheet, "imex-euler", dt=-1)),
        (["sphere", "terzopoulos-fleischer"],
         lambda: drape.run(drape.Scene.load("sphere"), "terzopoulos-fleischer")),
    ]:
        scene, method, *more = words
        if scene == "sphere" and "sphere" not in drape.scenes():
            continue
        said = command("run", scene, "--method", method, *more, code=2)
        sentence = refuses(call)
        assert said.splitlines()[-1] == f"drape: {sentence}", (said, sentence)
    refuses(lambda: drape.run(sheet, "imex-euler", threads=0), "threads", "1 to 1024")
    refuses(lambda: drape.run(sheet, "imex-euler", every=0), "every")
    system = drape.Scene.parse(sheet.json)
    refuses(lambda: drape.run(system, "imex-euler"), "--dt", "states no time")


def divergence_is_a_result():
    scene = drape.Scene.load("hanging-textile-1e4")
    run = drape.run(scene, "explicit-euler", dt=0.1, duration=10)
    assert run.verdict == run.ending == "diverged" and run.steps < 100 and "step" in run.reason
    assert math.isfinite(run.energies["total"][-1])


def comparisons_are_tables():
    scene = drape.Scene.load("hanging-textile-1e4")
    asked = dict(methods=["leapfrog", "midpoint", "imex-euler"], budget=6, duration=0.3)
    found = drape.compare(scene, **asked)
    assert 4 <= len(found.advice) <= 12 and found.advice[0].startswith("hanging-textile-1e4")
    assert str(found) == "\n".join(found.advice) and found.has_reference
    table = found.table
    assert len({len(column) for column in table.values()}) == 1
    place = [(m, round(dt, 15)) for m, dt in zip(table["method"], table["dt"])]
    taken = place.index((found.take["method"], round(found.take["dt"], 15)))
    assert table["meets_target"][taken] and table["error"][taken] <= 0.01
    facts = json.loads(found.json)
    assert len(facts["runs"]) == len(table["form"])
    refuses(lambda: drape.compare(scene, metric="beauty"), "metric", "beauty")
    refuses(lambda: drape.compare(scene, budget=-1), "budget")
    refuses(lambda: drape.compare(scene, ["no-such-method"]), "no-such-method")
    refuses(lambda: drape.compare(scene, target=-1), "--target")


def others_go_on_and_ctrl_c_ends_a_run():
    scene = drape.Scene.load("hanging-textile-1e4")
    ticks = []
    def tick():
        while not ticks or ticks[-1] is not None:
            ticks.append(time.monotonic())
            time.sleep(0.01)
    other = threading.Thread(target=tick, daemon=True)
    other.start()
    import _thread
    # A shell starts jobs in the background with this signal ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(0.5, _thread.interrupt_main).start()
    begin = time.monotonic()
    try:
        drape.run(scene, "leapfrog", dt=1e-6, duration=100)
    except KeyboardInterrupt:
        pass
    else:
        raise AssertionError("not interrupted")
    took = time.monotonic() - begin
    during = sum(tick is not None and tick >= begin for tick in ticks)
    ticks.append(None)
    assert took < 5 and during > 10, (took, during)


for check in [
    methods_and_scenes,
    scene_as_arrays,
    runs_have_the_bits_of_the_command,
    positions_over_time,
    faults_are_exceptions_with_the_sentence_of_the_command,
    divergence_is_a_result,
    comparisons_are_tables,
    others_go_on_and_ctrl_c_ends_a_run,
]:
    check()
    print(check.__name__)
