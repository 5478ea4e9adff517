"""Building blocks of the schema: tables, keys, and numbers with units, read into SI and described for JSON Schema."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, get_args

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from ..errors import ModelError
from .units import KINDS, Bounds, read_quantity

__all__ = ["Length", "PerPlanet", "Place", "SchemaTable", "Unit", "key", "metadata_of"]

PerPlanet = float | tuple[float, ...]  # one value, or one per planet


@dataclass(frozen=True, slots=True)
class Unit:
    """Annotation of a field: which quantities may stand there.

    kinds : names in `units.KINDS`; of a bare number the first. With two kinds the value is a `Quantity`.
    low, high : bounds [SI]; above : low itself is excluded.  inf : infinity is allowed.
    many : a list, one value per planet, is allowed (a tuple then).  lists : only a list is allowed, of `count` entries.
    words : words allowed in place of a number, kept as they are.  table : the schema of a table allowed there.
    """

    kinds: str
    low: float | None = None
    high: float | None = None
    above: bool = False
    inf: bool = False
    many: bool = False
    lists: bool = False
    count: int | None = None
    words: tuple[str, ...] = ()
    table: type[BaseModel] | None = None

    def read(self, value: object) -> object:
        """Return the SI value (float, tuple, Quantity, word or table) of what stands in the file."""
        if self.table is not None and isinstance(value, dict):
            return self.table.model_validate(value)
        bounds = Bounds(low=self.low, high=self.high, above=self.above, inf=self.inf)
        kinds = tuple(self.kinds.split())
        read = read_quantity(value, kinds, bounds, many=self.many or self.lists, one=not self.lists, words=self.words)
        if self.count is not None and isinstance(read, tuple) and len(read) != self.count:
            raise ModelError(f"a list of {len(read)}", given=value, allowed=f"a list of {self.count}")
        return read

    def describe(self) -> str:
        """Return the unit and kind of quantity in words, for the schema."""
        kinds = [KINDS[k] for k in self.kinds.split()]
        text = " or ".join(f"{k.name} [{k.unit}]" if k.unit else f"{k.name} [1]" for k in kinds)
        return text + (", one value or one per planet" if self.many else "")

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        forms: list[dict[str, Any]] = [{"type": "string"}]
        if not self.lists:
            forms.insert(0, {"type": "number"})
        if self.many or self.lists:
            forms.append({"type": "array", "items": {"type": ["number", "string"]}, "minItems": 1})
        if self.table is not None:
            self.table.model_rebuild()
            forms.append(handler(self.table.__pydantic_core_schema__))
        return {"anyOf": forms, "x-quantity": self.describe(), **({"x-words": list(self.words)} if self.words else {})}


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
