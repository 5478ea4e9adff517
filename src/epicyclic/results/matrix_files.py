"""Results as arrays by name, for MATLAB (``.mat``) and NumPy (``.npz``)."""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import checked
from ..errors import ModelError
from .whole_file import whole_file

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MATRIX_FILES", "save_matrices"]

MATRIX_FILES = (".mat", ".npz")
_NAME = 63  # characters of a name in MATLAB
_ATTRIBUTES = ("title", "version", "options", "warnings")


@checked
def save_matrices(result: xr.Dataset, path: str | Path) -> Path:
    """Write every variable of a result as an array of its name; the file appears whole or not at all.

    ``.mat`` (level 5) is opened by MATLAB's ``load`` and `scipy.io.loadmat`: one-dimensional arrays are columns, texts
    cells.  ``.npz`` is opened by `numpy.load`, without pickle.  Names, units and dims are those of the Dataset;
    ``dims_NAME`` lists the dims of a variable; title, version, options and warnings are texts.

    Raises
    ------
    ModelError : another suffix, or the file cannot be written.
    """
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in MATRIX_FILES:
        raise ModelError("no such kind of file", path="path", given=target.name, allowed=" or ".join(MATRIX_FILES))
    import numpy as np  # heavy: every command imports this file

    arrays: dict[str, Any] = {}
    for key, variable in result.variables.items():
        name = _valid(str(key))
        values = variable.values
        arrays[name] = values.astype(str) if values.dtype.kind in "OU" else values
        if variable.ndim > 1:
            arrays[_valid(f"dims_{name}")] = np.array([str(dim) for dim in variable.dims])
    arrays |= {name: np.array(str(result.attrs.get(name, ""))) for name in _ATTRIBUTES}
    with whole_file(target) as file:
        file.write(_mat(arrays) if kind == ".mat" else _npz(arrays))
    return target


def _npz(arrays: dict[str, Any]) -> bytes:
    import numpy as np

    content = BytesIO()
    np.savez_compressed(content, **arrays)
    return content.getvalue()


def _mat(arrays: dict[str, Any]) -> bytes:
    from scipy.io import savemat

    content = BytesIO()
    texts = {name: one.astype(object) if one.dtype.kind == "U" and one.ndim else one for name, one in arrays.items()}
    plain = {name: str(one) if one.dtype.kind == "U" and not one.ndim else one for name, one in texts.items()}
    savemat(content, plain, oned_as="column", do_compression=True, long_field_names=True)
    return content.getvalue()


def _valid(name: str) -> str:
    """A name as MATLAB takes it: a letter first, then letters, digits and underscores."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return (plain if plain[:1].isalpha() else f"x{plain}")[:_NAME]
