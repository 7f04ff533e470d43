"""Maps of ROS's map_server: a YAML file and a picture with a pixel per cell."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from protocol.errors import MapError, Problem
from protocol.process.installation import missing_library
from protocol.process.log import LOG
from protocol.scenario.model import Coordinate

MOST_CELLS = 16_000_000  # 200 m by 200 m with cells of 0.05 m; reading takes 1 GB of memory
FINEST, COARSEST = 1e-3, 10.0  # m, of a cell
_SAVED_UNKNOWN = 205  # grey in which map_saver paints the unknown
Mask = NDArray[np.bool_]
_Struct = TypeVar("_Struct")
Threshold = Annotated[float, Meta(ge=0, le=1)]
Yaw = Annotated[float, Meta(ge=-math.tau, le=math.tau)]


@dataclass(frozen=True)
class Occupancy:
    """A grid of square cells, rows from south to north, columns from west to east in the map's own frame."""

    occupied: Mask
    unknown: Mask  # neither occupied nor free
    resolution: float  # side of a cell, m
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m, m: outer corner of the first cell; rad: of rows

    def place(self, column: float, row: float) -> tuple[float, float]:
        """Position of a grid point, m; integers are corners of cells, half-integers centres."""
        x, y, yaw = self.origin
        u, v = self.resolution * column, self.resolution * row
        return x + math.cos(yaw) * u - math.sin(yaw) * v, y + math.sin(yaw) * u + math.cos(yaw) * v

    def cell(self, x: float, y: float) -> tuple[int, int] | None:
        """Row and column of the cell that contains (x, y), m; None outside of the map."""
        dx, dy, yaw = x - self.origin[0], y - self.origin[1], self.origin[2]
        column = math.floor((math.cos(yaw) * dx + math.sin(yaw) * dy) / self.resolution)
        row = math.floor((math.cos(yaw) * dy - math.sin(yaw) * dx) / self.resolution)
        rows, columns = self.occupied.shape
        return (row, column) if 0 <= row < rows and 0 <= column < columns else None


class _Head(msgspec.Struct):
    """Content of the YAML file, by map_server's names; unknown keys are ignored."""

    image: str
    resolution: Annotated[float, Meta(ge=FINEST, le=COARSEST)]
    origin: tuple[Coordinate, Coordinate, Yaw]
    occupied_thresh: Threshold = 0.65
    free_thresh: Threshold = 0.196
    negate: Annotated[int, Meta(ge=0, le=1)] = 0
    mode: Literal["trinary", "scale", "raw"] = "trinary"


def read_map(path: Path) -> Occupancy:
    """The map of a YAML file.

    Raises:
        MapError: the file or its picture cannot be read, or does not describe a map.
        UsageError: the libraries that read YAML and pictures are not installed.
    """
    head = _head(path)
    image = path.parent / head.image
    grey, opaque = _pixels(image)
    if head.mode == "raw":  # occupancy in per cent
        occupied, free = (grey <= 100) & (grey >= 100 * head.occupied_thresh), grey <= 100 * head.free_thresh
    else:
        darkness = (grey if head.negate else 255 - grey.astype(np.int16)) / 255.0
        occupied, free = darkness > head.occupied_thresh, (darkness < head.free_thresh) & opaque
        if not head.negate and free[grey == _SAVED_UNKNOWN].any():
            _warn_of_free_unknown(path.resolve(), head.free_thresh)
    return Occupancy(occupied, ~(occupied | free), head.resolution, head.origin)


@cache
def _warn_of_free_unknown(path: Path, threshold: float) -> None:
    """One warning for each file and process, which may read a map several times."""
    LOG.warning(
        f"{path}: free_thresh {threshold:g} makes grey {_SAVED_UNKNOWN} free, in which map savers paint "
        "what is unknown; 0.196 keeps it unknown"
    )


def read_yaml(path: Path) -> Any:
    """Content of a YAML file; raises as `read_map`."""
    try:
        import yaml
    except ModuleNotFoundError as error:
        raise missing_library("reading a map", "pyyaml", "maps") from error
    try:
        return yaml.safe_load(path.read_bytes())
    except OSError as error:
        raise as_map_error(path, "", f"cannot be read: {error.strerror or error}") from None
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        raise as_map_error(path, "", f"is not YAML: {' '.join(str(error).split())}") from None


def converted(path: Path, found: Any, kind: type[_Struct]) -> _Struct:
    """The content of a file as `kind`; raises MapError with the place of an invalid value."""
    try:
        return msgspec.convert(found, kind)
    except msgspec.ValidationError as error:
        text, _, place = str(error).partition(" - at `$")
        raise as_map_error(path, place.strip(".`"), f"{text[:1].lower()}{text[1:]}") from None


def _head(path: Path) -> _Head:
    head = converted(path, read_yaml(path), _Head)
    if not math.isfinite(head.resolution) or not all(map(math.isfinite, head.origin)):
        raise as_map_error(path, "resolution, origin", "must be finite numbers")
    if head.free_thresh > head.occupied_thresh:
        raise as_map_error(path, "free_thresh", f"must be at most occupied_thresh, {head.occupied_thresh:g}")
    return head


def _pixels(path: Path) -> tuple[NDArray[np.uint8], Mask]:
    """Brightness, 0 to 255, and which pixels are not transparent; the last row of the picture first."""
    try:
        from PIL import Image
    except ModuleNotFoundError as error:
        raise missing_library("reading a map", "pillow", "maps") from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # MOST_CELLS is the limit
            with Image.open(path, formats=("PPM", "PNG", "BMP")) as picture:
                width, height = picture.size
                if width * height > MOST_CELLS:
                    raise as_map_error(
                        path, "", f"has {width} x {height} pixels, at most {MOST_CELLS:,} can be read"
                    )
                if picture.mode[0] in "IF":  # what is above 255 would count as white
                    raise as_map_error(path, "", "has more than 8 bits a pixel: convert it to 8")
                opaque = np.asarray(picture.convert("RGBA"))[..., 3] == 255
                return np.flipud(np.asarray(picture.convert("L"))), np.flipud(opaque)
    except Image.DecompressionBombError:
        raise as_map_error(path, "", f"has too many pixels, at most {MOST_CELLS:,} can be read") from None
    except (OSError, SyntaxError, ValueError) as error:  # errors of damaged pictures
        text = getattr(error, "strerror", None) or "is not a complete PGM, PNG or BMP picture"
        raise as_map_error(path, "", text) from None


def as_map_error(path: Path, place: str, text: str) -> MapError:
    """Error at a place in a file; "" for the whole file."""
    return MapError(str(path), [Problem(place, text)])
