"""Slider of Coulomb friction with a memory: in series with the spring of a spline, force = k (delta - s).

At each step (derived here)

    s = argmin  k |delta - s|^2 / 2 + F_m |s - s_before|    over  |s| <= clearance

Along a first straight pull it equals the radial law; on reversal it sticks, where the radial law slides back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .rows import GroupRows

__all__ = ["AT_STOP", "Slider"]

Array = NDArray[np.float64]

# a slider within this share of the clearance is at the stop: rounding of its steps
AT_STOP = 1e-12
# Newton steps or halvings until its angle there is found to rounding [rad]
_SEARCH, _ANGLE = 60, 1e-15


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Slider:
    """Sliders of the groups (G,) with a memory; others have none.

    memory : whether a group has one.  stiffness [N/m], friction [N], clearance, slip_start [m] : of each.
    """

    rows: GroupRows
    memory: NDArray[np.bool_]
    stiffness: Array
    friction: Array
    clearance: Array
    slip_start: Array

    def slide(self, delta: Array, anchor: Array) -> Array:
        """Sliders (..., R) [m] after a step to delta (..., R) from sliders at `anchor` (..., R); 0 without a memory."""
        slider, _ = self._slid(delta, anchor)
        return np.where(self.rows.spread(self.memory), slider, 0.0)

    def _slid(self, delta: Array, anchor: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Slider (..., R) [m], and whether it is at its stop (..., G).

        Away from the stop it is anchor + w <1 - S_1 / |w|> with w = delta - anchor.
        """
        pull = delta - anchor
        length = self.rows.size(pull)
        factor = np.where(length > self.slip_start, 1.0 - self.slip_start / np.where(length > 0, length, 1.0), 0.0)
        slider: Array = anchor + self.rows.spread(factor) * pull
        out = self.memory & (self.rows.size(slider) > self.clearance * (1 + AT_STOP))
        if out.any():
            slider = np.where(self.rows.spread(out), self._at_stop(delta, anchor, out), slider)
        return slider, out

    def _at_stop(self, delta: Array, anchor: Array, out: NDArray[np.bool_]) -> Array:
        """Slider (..., R) [m] on the circle of the clearance, between the directions of delta and the anchor.

        Of a group of one row it is on the side of delta.  At the angle theta from delta and psi from the anchor the
        slope of the energy along the circle, k |delta| sin theta - F_m |anchor| sin psi / |slip|, is zero.  Safeguarded
        Newton steps on the whole array find it: the groups of all instants at once, in every step of a static history.
        """
        first, pair = self.rows.first, self.rows.pair
        second = first + pair
        dx, dy = delta[..., first], np.where(pair, delta[..., second], 0.0)
        px, py = anchor[..., first], np.where(pair, anchor[..., second], 0.0)
        reach, radius, c = np.hypot(dx, dy), np.hypot(px, py), self.clearance
        cross = dx * py - dy * px
        side = np.where(cross < 0, -1.0, 1.0)
        end = np.where(out & pair, np.arctan2(np.abs(cross), dx * px + dy * py), 0.0)
        # a slider at the stop already and pressed on may be held there by friction
        stuck = (radius >= c * (1 - AT_STOP)) & (reach * np.cos(end) >= c)
        stuck &= self.stiffness * reach * np.sin(end) <= self.friction
        low, high = np.where(stuck, end, 0.0), end
        theta = (low + high) / 2
        for _ in range(_SEARCH):
            psi = end - theta
            slip = np.sqrt(np.maximum((c - radius) ** 2 + 4 * c * radius * np.sin(psi / 2) ** 2, np.finfo(float).tiny))
            drag, lean = self.friction * radius / slip, np.sin(psi)
            slope = self.stiffness * reach * np.sin(theta) - drag * lean
            bend = self.stiffness * reach * np.cos(theta) + drag * (np.cos(psi) - c * radius * (lean / slip) ** 2)
            low, high = np.where(slope < 0, theta, low), np.where(slope < 0, high, theta)
            trial = theta - slope / np.where(bend > 0, bend, 1.0)
            trial = np.where((bend > 0) & (trial >= low) & (trial <= high), trial, (low + high) / 2)
            change, theta = np.abs(trial - theta), trial
            if np.all(change <= _ANGLE):
                break
        along, across = c * np.cos(theta), side * c * np.sin(theta)
        unit = np.where(reach > 0, reach, 1.0)
        result = np.empty_like(delta)
        result[..., second] = (along * dy + across * dx) / unit
        result[..., first] = (along * dx - across * dy) / unit
        return result

    def tangent(self, delta: Array, anchor: Array) -> Array:
        """Derivative (..., R, R) [N/m] of k (delta - s): k in stick, F_m / |delta - anchor| across the slip in slip.

        At the stop the slider moves along the circle only, by k / D of the motion of delta along it, with
        D = (k delta - F_m n) . s / |s|^2 + F_m (n . s / |s|)^2 / |s - anchor| and n the direction of the slip.
        """
        k, friction = self.stiffness, self.friction
        slider, stopped = self._slid(delta, anchor)
        moved, pull = self.rows.size(slider - anchor), self.rows.size(delta - anchor)
        slips = moved > 0
        unit = (delta - anchor) / self.rows.spread(np.where(pull > 0, pull, 1.0))
        free = np.where(slips, friction / np.where(pull > 0, pull, 1.0), k)
        result = self.rows.blocks(unit, along=np.where(slips, 0.0, k), across=free)
        if not stopped.any():
            return result
        radius = self.rows.size(slider)
        outward = slider / self.rows.spread(np.where(radius > 0, radius, 1.0))
        step = (slider - anchor) / self.rows.spread(np.where(slips, moved, 1.0))
        cosine = self.rows.dot(step, outward)
        D = (k * self.rows.dot(delta, outward) - friction * cosine) / np.where(stopped, self.clearance, 1.0)
        D += friction * cosine**2 / np.where(slips, moved, np.inf)
        across = np.where(slips & (D > 0), k - k**2 / np.where(D > 0, D, 1.0), k)
        held = self.rows.blocks(outward, along=k * np.ones_like(across), across=across)
        return np.where(self.rows.spread(stopped)[..., :, None], held, result)
