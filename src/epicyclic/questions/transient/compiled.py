"""The equation of motion compiled with numba, and classical Runge-Kutta steps [hairer1993, sec. II.1] over it.

Sums run in one order whatever the machine has, so that a run continued from its last state is the run, bit by bit.
A compiled caller kept on disk does not notice a change in another file: all compiled functions stand here.
"""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import numpy as np

from ...machine_code import machine_code
from ...system.system import Array, Index
from .equation import FlankNumbers, LawNumbers, Numbers, Steps

_jit = machine_code
# What every stage or step calls: a call copies the descriptors of all arrays of `Numbers`, a fifth of a step in all.
_inlined = partial(machine_code, forceinline=True)
TURN = 2 * np.pi
# As in `system.link_laws`: a slider this near the clearance is at its stop; its angle there, to rounding [rad].
_AT_STOP, _SEARCH, _ANGLE = 1e-12, 60, 1e-15
# As `integrators.AHEAD`.
_AHEAD = 1e-6
# Seconds of steps between two looks at Ctrl-C, and the steps of the first part: a millisecond or two of a small train.
_PART, _FIRST = 0.1, 1000


@_jit
def _phase(flank: FlankNumbers, at: Index, tones: Array, f: int, tau: float) -> tuple[float, int]:
    """Place [cycles] in its phase cell of a row with a table, and the first of the cubics there.

    at, tones : of `Numbers`.
    """
    table = flank.tables[flank.table[f]]
    first, phases, loads = table[0], table[1], table[2]
    sigma = flank.sense[f] * (tones[at[f]] * tau + flank.lead[f])
    sigma -= np.floor(sigma)
    cell = min(int(sigma * phases), phases - 1)
    return sigma - cell / phases, first + 2 * loads * cell


@_jit
def _cubic(cubics: Array, row: int, x: float) -> float:
    """One of the cubics at a place x [cycles] of its cell."""
    cubic = cubics[row]
    value: float = ((cubic[0] * x + cubic[1]) * x + cubic[2]) * x + cubic[3]
    return value


@_jit
def _tabulated(flank: FlankNumbers, f: int, x: float, row: int, gap: float) -> tuple[float, bool]:
    """Force [N] of a row with a table, and whether it presses; the gaps of rising forces are summed up to `gap` [m]."""
    loads, force = flank.tables[flank.table[f], 2], flank.tables[flank.table[f], 3]
    low = _cubic(flank.cubics, row, x)
    if gap <= low:
        return 0.0, False
    for j in range(1, loads):
        h = _cubic(flank.cubics, row + j, x)
        if gap < low + h:
            t = (gap - low) / h
            k0, k1 = _cubic(flank.cubics, row + loads + j - 1, x), _cubic(flank.cubics, row + loads + j, x)
            f0, f1 = flank.forces[force + j - 1], flank.forces[force + j]
            value = f0 * (1 + 2 * t) * (1 - t) ** 2 + f1 * t**2 * (3 - 2 * t)
            return value + h * (k0 * t * (1 - t) ** 2 + k1 * t**2 * (t - 1)), True
        low += h
    return flank.forces[force + loads - 1] + (gap - low) * _cubic(flank.cubics, row + 2 * loads - 1, x), True


@_inlined
def _add_products(A: Array, x: Array, out: Array) -> None:
    """Add x (m,) times A (m, c) to out (c,).

    Four rows a pass, in their turn: the sums stay in registers and have the bits of one row after the other.
    """
    m, c = A.shape
    whole = m - m % 4
    for j in range(0, whole, 4):
        x0, x1, x2, x3 = x[j], x[j + 1], x[j + 2], x[j + 3]
        for i in range(c):
            out[i] = out[i] + A[j, i] * x0 + A[j + 1, i] * x1 + A[j + 2, i] * x2 + A[j + 3, i] * x3
    for j in range(whole, m):
        for i in range(c):
            out[i] += A[j, i] * x[j]


@_inlined
def _interval(times: Array, t: float) -> int:
    """Number of the interval of the times of the program (k,) that holds a time [s]."""
    low, high = 0, times.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if times[middle] <= t else (low, middle)
    return low


@_inlined
def _stiffness(flank: FlankNumbers, at: Index, tones: Array, least: float, tau: float, turns: Array, k: Array) -> None:
    """Fill in k (F,) [N/m] of rows without a table; turns (4, F) is work space.  at, tones, least : of `Numbers`.

    All rows go through the orders together.  Rows of one tone share its cosine and sine.
    """
    # a name of its own: a loop that reads the array from its tuple is not vectorized
    F, wave, tone, c1, s1 = k.size, flank.wave, -1, 1.0, 0.0
    for f in range(F):
        if at[f] != tone:
            tone = at[f]
            angle = TURN * tau * tones[tone]
            c1, s1 = np.cos(angle), np.sin(angle)
        turns[0, f], turns[1, f], turns[2, f], turns[3, f], k[f] = c1, s1, c1, s1, 1.0
    for order in range(wave.shape[1]):
        for f in range(F):
            c, w = turns[2, f], turns[3, f]
            k[f] += wave[0, order, f] * c - wave[1, order, f] * w
            turns[2, f], turns[3, f] = c * turns[0, f] - w * turns[1, f], c * turns[1, f] + w * turns[0, f]
    for f in range(F):
        k[f] = flank.mean[f] * max(k[f], least)


@_inlined
def _instant_terms(
    N: Numbers, t: float, low: int, turns: Array, k: Array, cell: Index, e: Array, de: Array, push: Array
) -> tuple[float, float, float]:
    """Fill in k (F,) [N/m], errors e (M,) [m], rates de (M,) [m/s], modal force push (n,); returns s, s' and tau.

    t is in the interval `low` of the program.  Of a row with a table cell (F,) is the first of its cubics and k the
    place in them [cycles].
    """
    span, since = N.program.time[low + 1] - N.program.time[low], t - N.program.time[low]
    rise = (N.program.speed[low + 1] - N.program.speed[low]) / span
    s = N.program.speed[low] + rise * since
    tau = N.program.phase[low] + since * (N.program.speed[low] + rise * since / 2)
    n, F = push.size, N.flank.mean.size
    _stiffness(N.flank, N.tone, N.tones, N.least, tau, turns, k)
    if N.flank.tables.shape[0]:
        for f in range(F):
            if N.flank.table[f] >= 0:
                k[f], cell[f] = _phase(N.flank, N.tone, N.tones, f, tau)
    e[:] = 0.0
    de[:] = 0.0
    for f in range(F):  # arrays assigned whole would compile the words of their error, for seconds
        e[f] = N.opening[f]
    for j in range(N.gap_at.size):
        angle, turn = TURN * N.gap_at[j] * tau, TURN * N.gap_at[j] * s
        c, w = np.cos(angle), np.sin(angle)
        for r in range(e.size):
            e[r] += c * N.gap[0, j, r] - w * N.gap[1, j, r]
        if N.rated:
            for r in range(e.size):
                de[r] -= turn * (w * N.gap[0, j, r] + c * N.gap[1, j, r])
    for i in range(n):
        push[i] = N.steady[i] + rise * N.spin[i]
    for j in range(N.load.shape[0]):
        level = N.program.level[low, j] + (N.program.level[low + 1, j] - N.program.level[low, j]) * (since / span)
        for i in range(n):
            push[i] += level * N.load[j, i]
    for j in range(N.force_at.size):
        angle = TURN * N.force_at[j] * tau
        c, w = np.cos(angle), np.sin(angle)
        power = 1.0
        for p in range(4):
            if p == 3:
                power = rise
            if power != 0.0:
                for i in range(n):
                    push[i] += power * (c * N.force[0, p, j, i] - w * N.force[1, p, j, i])
            power *= s
    return s, rise, tau


@_jit
def _operators(damp: Array, stiff: Array, s: float, rise: float, operators: Array) -> None:
    """Fill in the operators of rate, then of position (n or 2 n, n) that depend on the speed, transposed, negative."""
    n = operators.shape[1]
    for i in range(n):
        for j in range(n):
            operators[i, j] = -damp[0, i, j] - s * damp[1, i, j]
    for i in range(operators.shape[0] - n):
        for j in range(n):
            operators[n + i, j] = -s * s * stiff[0, i, j] - s * stiff[1, i, j] - rise * stiff[2, i, j]


@_jit
def _add_passing(wave_at: Array, wave: Array, tau: float, operators: Array) -> None:
    """Add to the operators of position what links that pass a body have at an instant, transposed, negative."""
    n = operators.shape[1]
    for q in range(wave_at.size):
        c, w = np.cos(TURN * wave_at[q] * tau), np.sin(TURN * wave_at[q] * tau)
        for i in range(n):
            for j in range(n):
                operators[n + i, j] -= c * wave[0, q, i, j] - w * wave[1, q, i, j]


@_jit
def _slid(law: Array, dx: float, dy: float, ax: float, ay: float, pair: bool) -> tuple[float, float, bool]:
    """Slider (x, y) [m] of one group after a step to a stretch from where it was, and whether it is at its stop."""
    friction, start, clearance = -law[3], law[4], law[9]
    px, py = dx - ax, dy - ay
    length = np.sqrt(px * px + py * py)
    factor = 1.0 - start / length if length > start else 0.0
    sx, sy = ax + factor * px, ay + factor * py
    if np.sqrt(sx * sx + sy * sy) <= clearance * (1 + _AT_STOP):
        return sx, sy, False
    reach, radius = np.hypot(dx, dy), np.hypot(ax, ay)
    if reach == 0.0:
        return 0.0, 0.0, True
    theta, side = 0.0, 1.0
    if pair:
        theta, side = _angle(law[2], friction, clearance, reach, radius, dx * ay - dy * ax, dx * ax + dy * ay)
    along, across = clearance * np.cos(theta), side * clearance * np.sin(theta)
    return (along * dx - across * dy) / reach, (along * dy + across * dx) / reach, True


@_jit
def _angle(
    k: float, friction: float, c: float, reach: float, radius: float, cross: float, dot: float
) -> tuple[float, float]:
    """Angle [rad] from the stretch to the slider on the circle of the clearance, and its side (`link_laws`)."""
    side = -1.0 if cross < 0 else 1.0
    end = np.arctan2(abs(cross), dot)
    stuck = radius >= c * (1 - _AT_STOP) and reach * np.cos(end) >= c and k * reach * np.sin(end) <= friction
    low, high = end if stuck else 0.0, end
    theta = (low + high) / 2
    for _ in range(_SEARCH):
        psi = end - theta
        slip = np.sqrt(max((c - radius) ** 2 + 4 * c * radius * np.sin(psi / 2) ** 2, 2.2250738585072014e-308))
        drag, lean = friction * radius / slip, np.sin(psi)
        slope = k * reach * np.sin(theta) - drag * lean
        bend = k * reach * np.cos(theta) + drag * (np.cos(psi) - c * radius * (lean / slip) ** 2)
        low, high = (theta, high) if slope < 0 else (low, theta)
        trial = theta - slope / (bend if bend > 0 else 1.0)
        if not (bend > 0 and low <= trial <= high):
            trial = (low + high) / 2
        change, theta = abs(trial - theta), trial
        if change <= _ANGLE:
            break
    return theta, side


@_jit
def _held(
    law: Array, dx: float, dy: float, vx: float, vy: float, ax: float, ay: float, pair: bool
) -> tuple[float, float]:
    """Force (x, y) [N] of one group with a memory at a stretch and rate: its spring, and lag times tangent times rate.

    The tangent is that of `link_laws`, a little ahead of the motion, see `integrators`.
    """
    k, friction, lag = law[2], -law[3], law[8]
    sx, sy, _ = _slid(law, dx, dy, ax, ay, pair)
    fx, fy = k * (dx - sx), k * (dy - sy)
    speed = np.sqrt(vx * vx + vy * vy)
    if lag == 0.0 or speed == 0.0:
        return fx, fy
    dx, dy = dx + _AHEAD * law[4] / speed * vx, dy + _AHEAD * law[4] / speed * vy
    sx, sy, stopped = _slid(law, dx, dy, ax, ay, pair)
    mx, my = sx - ax, sy - ay
    moved = np.sqrt(mx * mx + my * my)
    along, across, nx, ny = k, k, 0.0, 0.0
    if stopped:
        radius = np.sqrt(sx * sx + sy * sy)
        nx, ny = sx / (radius if radius > 0 else 1.0), sy / (radius if radius > 0 else 1.0)
        if moved > 0:
            cosine = (mx * nx + my * ny) / moved
            D = (k * (dx * nx + dy * ny) - friction * cosine) / law[9] + friction * cosine**2 / moved
            across = k - k * k / D if D > 0 else k
    elif moved > 0:
        pull = np.sqrt((dx - ax) ** 2 + (dy - ay) ** 2)
        nx, ny = (dx - ax) / pull, (dy - ay) / pull
        along, across = 0.0, friction / pull
    normal = (along - across) * (nx * vx + ny * vy)
    return fx + lag * (normal * nx + across * vx), fy + lag * (normal * ny + across * vy)


@_jit
def _pressed(contacts: Array, F: int, law: Array, x: Array, u: Array, e: Array, de: Array, force: Array) -> None:
    """Fill in the forces [N, N m] of one group of contacts: the law, and lag times tangent times rate; F flanks."""
    first, count = int(law[0]), int(law[1])
    p, lag, begin = law[7], law[8], int(law[10])
    for i in range(first, first + count):
        force[i] = 0.0
    for j in range(begin, begin + int(law[11])):
        contact = contacts[j]
        approach, rate = -contact[5], 0.0
        for i in range(count):
            approach += contact[i] * (x[F + first + i] - e[F + first + i])
            rate += contact[i] * (u[F + first + i] - de[F + first + i])
        if approach >= 0.0:
            pull = contact[6] * (approach**p + lag * p * approach ** (p - 1.0) * rate)
            for i in range(count):
                force[first + i] += pull * contact[i]


@_jit
def _groups(link: LawNumbers, F: int, x: Array, u: Array, e: Array, de: Array, slider: Array, force: Array) -> None:
    """Fill in the forces (R,) [N] of the groups; stretch x [m] and rate u [m/s], (M,), slider (R,) [m]; F flanks."""
    for g in range(link.numbers.shape[0]):
        first, count = int(link.numbers[g, 0]), int(link.numbers[g, 1])
        k, friction, lag = link.numbers[g, 2], link.numbers[g, 3], link.numbers[g, 8]
        if link.numbers[g, 11] > 0.0:
            _pressed(link.contacts, F, link.numbers[g], x, u, e, de, force)
            continue
        if friction < 0.0:
            i, j = F + first, F + first + count - 1
            pair = count == 2
            dy, vy = (x[j] - e[j], u[j] - de[j]) if pair else (0.0, 0.0)
            sy = slider[first + 1] if pair else 0.0
            fx, fy = _held(link.numbers[g], x[i] - e[i], dy, u[i] - de[i], vy, slider[first], sy, pair)
            force[first] = fx
            if pair:
                force[first + 1] = fy
            continue
        rho, radial = 0.0, 0.0
        for i in range(F + first, F + first + count):
            rho += (x[i] - e[i]) ** 2
            radial += (x[i] - e[i]) * (u[i] - de[i])
        rho = np.sqrt(rho)
        value, slope = min(k * rho, friction), k if rho < link.numbers[g, 4] else 0.0
        beyond = rho - link.numbers[g, 5]
        if beyond >= 0.0:
            value += link.numbers[g, 6] * beyond ** link.numbers[g, 7]
            slope += link.numbers[g, 6] * link.numbers[g, 7] * beyond ** (link.numbers[g, 7] - 1.0)
        secant = value / rho if rho > 0.0 else slope
        for i in range(F + first, F + first + count):
            gap, speed = x[i] - e[i], u[i] - de[i]
            along = radial / (rho * rho) * gap if rho > 0.0 else 0.0
            force[i - F] = secant * gap + lag * (slope * along + secant * (speed - along))


@_jit
def _move_sliders(laws: Array, gaps: Array, F: int, y: Array, e: Array, slider: Array) -> None:
    """Move the sliders (R,) [m] at the end of a step, in place; laws : numbers of `LawNumbers`, gaps : of `Numbers`."""
    for g in range(laws.shape[0]):
        if laws[g, 3] < 0.0:
            first, pair = int(laws[g, 0]), int(laws[g, 1]) == 2
            dx, dy = -e[F + first], -e[F + first + 1] if pair else 0.0
            for i in range(y.size):
                dx += gaps[i, F + first] * y[i]
                if pair:
                    dy += gaps[i, F + first + 1] * y[i]
            sx, sy, _ = _slid(laws[g], dx, dy, slider[first], slider[first + 1] if pair else 0.0, pair)
            slider[first] = sx
            if pair:
                slider[first + 1] = sy


@_inlined
def _slope(
    N: Numbers, k: Array, cell: Index, e: Array, de: Array, push: Array, operators: Array, y: Array, v: Array,
    slider: Array, x: Array, u: Array, r: Array, g: Array, z: Array, press: Array, a: Array,
) -> None:  # fmt: skip
    """Fill in y'' a (n,) of the state y, v (n,) and slider (R,), and the forces of the flanks press (F,) [N].

    x, u, r (M,), g (R,) and z, as long as the operators, are work space.
    """
    n, M, F = y.size, e.size, N.flank.mean.size
    x[:] = 0.0
    u[:] = 0.0
    _add_products(N.gaps, y, x)
    if N.rated:
        _add_products(N.gaps, v, u)
    for i in range(F):
        gap = x[i] - e[i]
        force = 0.0
        if N.pull or gap > 0.0:
            force = k[i] * gap + N.drag[i] * (u[i] - de[i])
        press[i] = force
        r[i] = N.linear[i] * x[i] - force
    if N.flank.tables.shape[0]:  # a loop of its own: that of linear rows is short and straight
        for i in range(F):
            if N.flank.table[i] >= 0:
                force, pressed = _tabulated(N.flank, i, k[i], cell[i], x[i] - e[i])
                if pressed:
                    force += N.drag[i] * (u[i] - de[i])
                press[i] = force
                r[i] = N.linear[i] * x[i] - force
    if M > F:
        _groups(N.link, F, x, u, e, de, slider, g)
        for i in range(M - F):
            total = 0.0
            for j in range(M - F):
                total += N.link.tangent[i, j] * x[F + j]
            r[F + i] = total - g[i]
    for i in range(n):
        a[i] = push[i] - N.squared[i] * y[i] - N.rate[i] * v[i]
    _add_products(N.pulls, r, a)
    for i in range(z.size):
        z[i] = v[i] if i < n else y[i - n]
    _add_products(operators, z, a)


@_inlined
def _note(
    whole: Index, loaded: int, force: Array, moment: float, span: float, total: Array, mesh: Array, flank: Array
) -> None:
    """Add the forces of all flanks (F,) [N] at the beginning of a step to a tally, as `integrators.note`.

    whole, loaded : of `Numbers`.  moment, span : beginning and length of the step [s].
    total : (w, 3) work space: force, any and far flank pressing.  mesh, flank : arrays of `integrators.Tally`.
    """
    total[:] = 0.0
    for f in range(force.size):
        if not np.isfinite(force[f]):
            return
    for f in range(force.size):
        w, far = whole[f], f >= loaded
        total[w, 0] += -force[f] if far else force[f]
        if force[f] != 0.0:
            total[w, 1] = 1.0
            if far:
                total[w, 2] = 1.0
        if force[f] > flank[f, 0]:
            flank[f, 0] = force[f]
        if not force[f] > 0.0:
            flank[f, 1] += span
    for w in range(mesh.shape[0]):
        if total[w, 0] < mesh[w, 0]:
            mesh[w, 0], mesh[w, 1] = total[w, 0], moment
        if total[w, 0] > mesh[w, 2]:
            mesh[w, 2], mesh[w, 3] = total[w, 0], moment
        if total[w, 1] == 0.0:
            mesh[w, 4] += span
        elif mesh[w, 7] == 0.0:
            mesh[w, 6] += 1.0
        if total[w, 2] > 0.0:
            mesh[w, 5] += span
        mesh[w, 7] = total[w, 1]


@_jit
def _run(
    N: Numbers, y: Array, v: Array, slider: Array, first: int, begin: float, step: float, keep: int, done: int,
    count: int, out: Array, sliders: Array, mesh: Array, flank: Array,
) -> int:  # fmt: skip
    """So many steps from step `first + done` on, the state and the tally (`integrators.Tally`) changed in place.

    Every `keep`-th state is entered in out (samples, 2, n) and sliders (samples, R), the first one after `keep` steps
    from `first`.  Returns the number of finite samples where one is not, else -1.
    """
    n, M, F = y.size, N.gaps.shape[1], N.flank.mean.size
    k, e, de, push, press = np.empty(F), np.empty(M), np.empty(M), np.empty(n), np.empty(F)
    x, u, r, g = np.empty(M), np.empty(M), np.empty(M), np.empty(M - F)
    cell, total = np.zeros(F, np.int64), np.empty((mesh.shape[0], 3))
    y1, v1, a = np.empty(n), np.empty(n), np.empty(n)
    dy, dv = np.empty(n), np.empty(n)
    passing = N.wave_at.size > 0
    positions, turning = passing or bool(np.any(N.stiff)), passing or bool(np.any(N.stiff) or np.any(N.damp))
    operators = np.zeros(((2 * n if positions else n) if turning else 0, n))
    z = np.empty(operators.shape[0])
    varying = turning and (passing or bool(np.any(N.program.speed != N.program.speed[0])))
    if turning:
        _operators(N.damp, N.stiff, N.program.speed[0], 0.0, operators)
    turns = np.empty((4, F))
    low = -1
    for number in range(done, done + count):
        index = first + number
        t = begin + index * step
        middle, end = begin + (index + 0.5) * step, begin + (index + 1) * step
        before, low = low, _interval(N.program.time, middle)
        for stage in range(4):
            # a step begins with the terms with which the one before has ended, in one interval of the program
            if stage == 1 or stage == 3 or (stage == 0 and low != before):
                at = t if stage == 0 else (middle if stage == 1 else end)
                s, rise, tau = _instant_terms(N, at, low, turns, k, cell, e, de, push)
                if varying:
                    _operators(N.damp, N.stiff, s, rise, operators)
                if passing:
                    _add_passing(N.wave_at, N.wave, tau, operators)
            if stage == 0:
                for i in range(n):
                    y1[i], v1[i] = y[i], v[i]
                weight = 1.0
            else:
                reach = step if stage == 3 else 0.5 * step
                weight = 1.0 if stage == 3 else 2.0
                for i in range(n):
                    # the slope of y at a stage is the v of the stage before
                    vi = v1[i]
                    y1[i], v1[i] = y[i] + reach * vi, v[i] + reach * a[i]
            _slope(N, k, cell, e, de, push, operators, y1, v1, slider, x, u, r, g, z, press, a)
            if stage == 0:
                _note(N.whole, N.loaded, press, t, step, total, mesh, flank)
            for i in range(n):
                if stage == 0:
                    dy[i], dv[i] = v1[i], a[i]
                else:
                    dy[i] += weight * v1[i]
                    dv[i] += weight * a[i]
        for i in range(n):
            y[i] += step / 6.0 * dy[i]
            v[i] += step / 6.0 * dv[i]
        if slider.size:
            _move_sliders(N.link.numbers, N.gaps, F, y, e, slider)
        if (number + 1) % keep == 0 and not _enter(number // keep, y, v, slider, out, sliders):
            return number // keep
    return -1


@_jit
def _enter(sample: int, y: Array, v: Array, slider: Array, out: Array, sliders: Array) -> bool:
    """Enter a state as a sample of out (samples, 2, n) and sliders (samples, R); whether it is finite."""
    total = 0.0
    for i in range(y.size):
        out[sample, 0, i], out[sample, 1, i] = y[i], v[i]
        total += y[i] + v[i]
    for i in range(slider.size):
        sliders[sample, i] = slider[i]
    return bool(np.isfinite(total))


def advance(N: Numbers, state: Array, slider: Array, steps: Steps, *, mesh: Array, flank: Array) -> tuple[Array, Array]:
    """States (samples, 2, n) and sliders (samples, R) after every `keep` steps; nan once not finite.

    Compiled steps do not hear Ctrl-C: they are taken in parts of a fraction of a second, which changes no bit.

    Parameters
    ----------
    state : (2, n) and slider : (R,) at step `first`.
    mesh, flank : arrays of `integrators.Tally`, to which all these steps are added in place.
    """
    begin, step, first, keep, samples = steps
    out, sliders = np.full((samples, 2, N.squared.size), np.nan), np.full((samples, slider.size), np.nan)
    y, v, s = state[0].copy(), state[1].copy(), slider.copy()
    run: Any = _run
    done, part, finite = 0, _FIRST, -1
    while done < samples * keep and finite < 0:
        count, start = min(part, samples * keep - done), time.perf_counter()
        finite = run(N, y, v, s, first, begin, step, keep, done, count, out, sliders, mesh, flank)
        done += count
        spent = time.perf_counter() - start
        part = max(1, min(int(count * _PART / max(spent, 1e-6)), 4 * part))
    if finite >= 0:
        out[finite:], sliders[finite:] = np.nan, np.nan
    return out, sliders
