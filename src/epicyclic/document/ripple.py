"""Ripple of torque or motion at a shaft: components of exact order or frequency, or a torque table over whole turns."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Annotated, Any, Self

from pydantic import GetJsonSchemaHandler, ValidationInfo, model_validator
from pydantic_core import CoreSchema

from ..errors import ModelError
from .schema_fields import SchemaTable, Unit, key

_MOST_ORDER, _MOST_DENOMINATOR, MOST_POINTS, _LONGEST = 1000, 1000, 1000, 40
_PATTERN = r"^\s*[0-9.]+(\s*/\s*[0-9]+)?\s*$"
_ORDER = f'above 0 up to {_MOST_ORDER}, exact with a denominator up to {_MOST_DENOMINATOR}: 2, 0.5, "1/3"'


class OrderUnit(Unit):
    """Annotation of an order: cycles in one turn of a shaft, an exact fraction."""

    def read(self, value: object, info: ValidationInfo[Any] | None = None) -> Fraction:
        """Return the order as it is written."""
        try:
            if isinstance(value, bool) or not isinstance(value, int | float | str):
                raise ValueError
            if isinstance(value, str) and (len(value) > _LONGEST or re.match(_PATTERN, value) is None):
                raise ValueError
            order = Fraction("".join(str(value).split()))
        except (ValueError, ZeroDivisionError):
            raise ModelError("not an order", given=value, allowed=_ORDER) from None
        if not 0 < order <= _MOST_ORDER or order.denominator > _MOST_DENOMINATOR:
            raise ModelError("out of range", given=value, allowed=_ORDER)
        return order

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        text = {"type": "string", "pattern": _PATTERN}
        return {"anyOf": [{"type": "number", "minimum": 1 / _MOST_DENOMINATOR, "maximum": _MOST_ORDER}, text]}


class RippleTable(SchemaTable):
    """A component of a ripple, A cos(order theta + phase) with the angle theta of a shaft, or a table."""

    order: Annotated[Fraction, OrderUnit("ratio")] | None = key(None, 'cycles in one turn, 2 or "1/2"')
    of: str | None = key(None, "member whose turn counts; default the shaft itself")
    frequency: Annotated[float, Unit("frequency", low=1e-3)] | None = key(
        None, "frequency that does not follow the speed, in place of an order"
    )
    torque: Annotated[float, Unit("torque", low=0)] | None = key(None, "amplitude of an external torque")
    angle: Annotated[float, Unit("angle", low=0)] | None = key(None, "amplitude of an imposed angle")
    speed: Annotated[float, Unit("speed", low=0)] | None = key(
        None, "amplitude of an imposed speed, at the operating speed; it follows the speed"
    )
    phase: Annotated[float, Unit("angle")] | None = key(None, "phase of the cosine; default 0")
    angles: Annotated[tuple[float, ...], Unit("angle", lists=True)] | None = key(
        None, "equally spaced angles of whole turns of the shaft, from 0"
    )
    torques: Annotated[tuple[float, ...], Unit("torque", lists=True)] | None = key(
        None, "torques at the angles; their mean is that of the operation"
    )
    file: str | None = key(None, "CSV file beside the model file, in place of angles and torques")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """Refuse what is not one wave or one table."""
        amplitudes, waves = ("torque", "angle", "speed", "torques"), ("order", "frequency", "angles")
        for names, what in ((amplitudes, "an amplitude"), (waves, "an order")):
            given = [name for name in names if getattr(self, name) is not None]
            if len(given) != 1:
                problem = f"{' and '.join(given)} together" if given else f"without {what}"
                raise ModelError(problem, allowed=f"one of {', '.join(names)}")
        if (self.angles is None) != (self.torques is None):
            raise ModelError("half a table", allowed="angles and torques, or an order and an amplitude")
        if self.frequency is not None and self.of is not None:
            raise ModelError("of a shaft, beside frequency", path="of", given=self.of, allowed="order")
        if self.angles is not None:
            self._check_table(self.angles, self.torques or ())
        return self

    def _check_table(self, angles: tuple[float, ...], torques: tuple[float, ...]) -> None:
        if self.phase is not None:
            raise ModelError("beside a table", path="phase", given=self.phase, allowed="angles that count from 0")
        if len(angles) != len(torques):
            raise ModelError(f"{len(torques)} torques", path="torques", allowed=f"{len(angles)}, one for each angle")
        if not 3 <= len(angles) <= MOST_POINTS:
            raise ModelError(f"{len(angles)} points", path="angles", allowed=f"3 to {MOST_POINTS}")
