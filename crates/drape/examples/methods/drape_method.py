"""A time integrator in Python for drape, over the protocol drape-method/1. Standard library only.

Write a class with a dictionary `hello`, `system(self, system, t)` and `step(self, x, v, pins, t, h)`,
and end with `serve(YourClass())`. `x` and `v` are flat lists of 3 n numbers, m and m/s; `pins` are the
places of the pinned particles at t + h. `step` returns x, v and a dictionary of costs.
"""

import array
import json
import os
import sys

# The protocol has the output for itself: whatever a library prints goes to standard error. Import
# this module first.
OUT = os.fdopen(os.dup(1), "wb")
os.dup2(2, 1)


def numbers(data):
    """Little-endian 64-bit floats as a list."""
    values = array.array("d", data)
    if sys.byteorder == "big":
        values.byteswap()
    return values.tolist()


def data(values):
    """A list of numbers as little-endian 64-bit floats."""
    values = array.array("d", values)
    if sys.byteorder == "big":
        values.byteswap()
    return values.tobytes()


def answer(method, request, body):
    """The answer to one request: a dictionary, and the bytes behind its line."""
    if request["do"] == "hello":
        return {"protocol": "drape-method/1", **method.hello}, b""
    if request["do"] == "system":
        method.system(request["system"], request["time_s"])
    elif request["do"] == "restart" and hasattr(method, "restart"):
        method.restart()
    elif request["do"] == "step":
        n = len(method.mass) * 3
        x, v, pins = body[:n], body[n : 2 * n], body[2 * n :]
        x, v, costs = method.step(x, v, pins, request["time_s"], request["step_s"])
        state = data(x) + data(v)
        return {"bytes": len(state), **costs}, state
    return {"ok": True}, b""


def serve(method):
    """Answers drape until it closes the pipe."""
    pipe = sys.stdin.buffer
    for line in iter(pipe.readline, b""):
        request = json.loads(line)
        try:
            body = numbers(pipe.read(request.get("bytes", 0)))
            reply, state = answer(method, request, body)
        except Exception as error:
            reply, state = {"error": f"{type(error).__name__}: {error}"}, b""
        OUT.write(json.dumps(reply).encode() + b"\n" + state)
        OUT.flush()
