"""experiment"""
from __future__ import annotations
from itertools import product
import numpy as np
from ...system.system import Array
from ..harmonic.gmres import gmres
from ..harmonic.lattice import kept_points
from ..harmonic.response import Response
from .balance import Problem, evaluate, linearised, problem, unknowns
from .newton import Found, dynamic_size
from .precondition import preconditioner, receptance
from .slow import SlowTones

def torus_points(harmonics, cross, slow):
    mesh = kept_points(harmonics, cross, mirrored=False).points.tolist()
    reach = [range(-H, H + 1) for H in slow]
    orders = [s for s in product(*reach) if sum(abs(a) / H for a, H in zip(s, slow)) <= 1 + 1e-9]
    pts = [(*a, *s) for a in mesh for s in orders]
    pts = [p for p in pts if next((a for a in p if a), 1) > 0]
    return np.array(sorted(pts, key=lambda p: (any(p), p)), dtype=np.int64)

def torus_problem(ready: Response, slow: SlowTones, harmonics, cross, orders, fine=8, slowfine=4):
    pts = torus_points(harmonics, cross, orders)
    tones = np.concatenate([ready.omega, 2*np.pi*np.array([float(t) for t in slow.tones])])
    counts = (*(fine*H for H in harmonics), *(slowfine*H for H in orders))
    D = len(orders)
    lines = [((*p, *(0,)*D), False, line) for p, line in ready.lines.mesh] + list(slow.lines)
    return problem(ready, pts, tones, counts, lines)

def embed(given, points, y):
    place = {tuple(p): i for i, p in enumerate(given.grid.points.tolist())}
    out = np.zeros(unknowns(given))
    D = given.grid.points.shape[1]
    for i, p in enumerate(points.tolist()):
        k = place.get((*p, *(0,)*(D-len(p))))
        if k is not None: out[:, k] = y[:, i]
    return out

def solve(given: Problem, start, speed, tolerance=1e-6, steps=20, pre=True, forcing=1e-2, log=None):
    state, calls = evaluate(given, start, speed), 0
    comp = receptance(given, state) if pre else None
    for count in range(steps+1):
        size = dynamic_size(state.y)
        if log is not None: log.append((state.norm/size, calls))
        if state.norm <= tolerance*size: return Found(state=state, converged=True, steps=count, calls=calls)
        op = linearised(given, state)
        inv = preconditioner(given, state, comp) if pre else (lambda x: x)
        sh = unknowns(given)
        right = inv(state.residual)
        rn=np.linalg.norm(right)
        move, _, used = gmres(lambda x: inv(op(x.reshape(sh))).reshape(1,-1), right.reshape(1,-1), target=np.array([max(forcing*rn, .1*tolerance*size)]), restarts=1, basis=60)
        calls += used
        f=1.0
        for _ in range(6):
            trial = evaluate(given, state.y - f*move.reshape(sh), speed)
            if trial.norm < (1-.1*f)*state.norm: break
            f/=2
        else: break
        state=trial
    return Found(state=state, converged=False, steps=count, calls=calls)
