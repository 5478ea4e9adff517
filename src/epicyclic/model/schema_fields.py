"""Building blocks of the schema: tables, keys, and numbers with units, read into SI and described for JSON Schema."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, get_args

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from ..errors import ModelError
from .bare_numbers import Ladder, Reading
from .units import KINDS, Bounds, read_quantity

__all__ = ["Length", "PerPlanet", "Place", "SchemaTable", "Unit", "key", "metadata_of", "text_form"]

PerPlanet = float | tuple[float, ...]  # one value, or one per planet


@dataclass(frozen=True, slots=True)
class Unit:
    """Annotation of a field: which quantities may stand there.

    kinds : names in `units.KINDS`; of a bare number the first. With two kinds the value is a `Quantity`.
    low, high : bounds [SI]; above, below : low, high itself is excluded.  inf : infinity is allowed.
    many : a list, one value per planet, is allowed (a tuple then).  lists : only a list is allowed, of `count` entries.
    words : words allowed in place of a number, kept as they are.  table : the schema of a table allowed there.
    reason : why the bounds are as they are, for the error.
    likely : units that a bare number likely means, where they are others than of the kind (`bare_numbers.LIKELY`).
    """

    kinds: str
    low: float | None = None
    high: float | None = None
    above: bool = False
    below: bool = False
    inf: bool = False
    many: bool = False
    lists: bool = False
    count: int | None = None
    words: tuple[str, ...] = ()
    table: type[BaseModel] | None = None
    reason: str = ""
    likely: Ladder | None = None

    def read(self, value: object, info: ValidationInfo[Any] | None = None) -> object:
        """Return the SI value (float, tuple, Quantity, word or table) of what stands in the file.

        info : its context is a `Reading`, or nothing.  Raises ModelError.
        """
        context: Reading | None = None if info is None else info.context
        if self.table is not None and isinstance(value, dict):
            return self.table.model_validate(value, context=context)
        if context is not None:
            context.look(value, tuple(self.kinds.split()), self.likely, bounds=self._bounds, many=self.many)
        try:
            read = self._quantity(value, listed=context is not None and context.listed)
        except ModelError as error:
            if not self.reason:
                raise
            allowed = f"{error.allowed}; {self.reason}"
            raise ModelError(error.problem, given=error.given, allowed=allowed) from None
        if self.count is not None and isinstance(read, tuple) and len(read) != self.count:
            raise ModelError(f"a list of {len(read)}", given=value, allowed=f"a list of {self.count}")
        return read

    def _quantity(self, value: object, *, listed: bool) -> object:
        """Return the SI value of a number or list."""
        return read_quantity(
            value,
            tuple(self.kinds.split()),
            self._bounds,
            many=self.many or self.lists,
            one=not self.lists,
            words=self.words,
            listed=listed,
        )

    @property
    def _bounds(self) -> Bounds:
        return Bounds(low=self.low, high=self.high, above=self.above, below=self.below, inf=self.inf)

    def describe(self) -> str:
        """Return the unit and kind of quantity in words, for the schema."""
        kinds = [KINDS[k] for k in self.kinds.split()]
        text = " or ".join(f"{k.name} [{k.unit}]" if k.unit else f"{k.name} [1]" for k in kinds)
        span = self._span()
        return text + (f", {span}" if span else "") + (", one value or one per planet" if self.many else "")

    def _span(self) -> str:
        """Return the bounds in words, those of angles in degrees; "" without."""
        degrees = self.kinds == "angle"
        low, high = (None if v is None else round(math.degrees(v), 6) if degrees else v for v in (self.low, self.high))
        unit = " deg" if degrees else ""
        if low is not None and high is not None and not (self.above or self.below):
            return f"{low:g} to {high:g}{unit}"
        first = "" if low is None else f"above {low:g}{unit}" if self.above else f"{low:g}{unit} or more"
        last = "" if high is None else f"below {high:g}{unit}" if self.below else f"up to {high:g}{unit}"
        return " and ".join(part for part in (first, last) if part)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        forms = [form for kind in self.kinds.split() for form in self.forms(kind)]
        if self.words:
            forms.append({"enum": list(self.words)})
        if self.table is not None:
            self.table.model_rebuild()
            forms.append(handler(self.table.__pydantic_core_schema__))
        return {"anyOf": forms, "x-quantity": self.describe(), **({"x-words": list(self.words)} if self.words else {})}

    def forms(self, kind: str) -> list[dict[str, Any]]:
        """Return the schemas of what may stand there as one kind of quantity; texts by reference, see `text_form`."""
        zero = self.low is None or self.low < 0 or (self.low == 0 and not self.above)
        one: list[dict[str, Any]] = [{"enum": [0]}] if zero else []
        if not KINDS[kind].unit:
            one = [{"type": "number"}]
        if self.inf:
            one.append({"type": "number", "minimum": _INFINITY})
        one.append(text_form(kind, inf=self.inf, many=False))
        if not (self.many or self.lists):
            return one
        lists = [
            text_form(kind, inf=self.inf, many=True),
            {"type": "array", "items": {"anyOf": one}, "minItems": self.count or 1, **self._most()},
        ]
        return lists if self.lists else one + lists

    def _most(self) -> dict[str, int]:
        return {} if self.count is None else {"maxItems": self.count}


# what only infinity is not below: JSON itself has no word for it, TOML has
_INFINITY = 1.7976931348623157e308


def text_form(kind: str, *, inf: bool, many: bool) -> dict[str, Any]:
    """Return the reference to the schema of the texts of one kind of quantity; `json_schema` puts these beside it."""
    return {"x-texts": f"{kind}{'_or_inf' if inf else ''}{'_list' if many else ''}"}


Length = Annotated[float, Unit("length", low=0, above=True)]  # [m], above 0
Place = Annotated[float, Unit("length")]  # [m], of any sign


def key(default: Any, text: str, **more: Any) -> Any:
    """Return a field with a default and a description for the schema."""
    return Field(default, description=text, **more)


class SchemaTable(BaseModel):
    """A table of the file: frozen, unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, defer_build=True)


def metadata_of(field: FieldInfo) -> tuple[Any, ...]:
    """Annotations of a field, those of the members of a union among them."""
    return (*field.metadata, *_nested_metadata(field.annotation))


def _nested_metadata(annotation: Any) -> tuple[Any, ...]:
    own = getattr(annotation, "__metadata__", ())
    return (*own, *(entry for part in get_args(annotation) for entry in _nested_metadata(part)))
