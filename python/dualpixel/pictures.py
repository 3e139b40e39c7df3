"""Reads the pictures of captures and data sets with NumPy alone: PNG of 8 and 16 bits, and scanline EXR."""

from __future__ import annotations

import os
import struct
import zlib
from typing import Union

import numpy as np

from .errors import InputError

Path = Union[str, "os.PathLike[str]"]

_PNG_CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}
_EXR_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
_MOST_BYTES = 1 << 31
_EXR_LINES = {0: 1, 2: 1, 3: 16}  # lines a chunk: no compression, a zip for each line, a zip for sixteen


def _read(path: Path) -> bytes:
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise InputError(f"{os.fspath(path)}: cannot be read: {error.strerror}") from error


def _paeth(left: int, up: int, corner: int) -> int:
    to_left, to_up, to_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
    if to_left <= to_up and to_left <= to_corner:
        return left
    return up if to_up <= to_corner else corner


def _unfiltered(kind: int, line: np.ndarray, above: np.ndarray, step: int) -> np.ndarray:
    """A line of bytes without the PNG filter `kind` (PNG specification, section 9)."""
    if kind == 0:
        return line
    if kind == 1:  # of the pixel to the left
        return np.add.accumulate(line.reshape(-1, step), axis=0, dtype=np.uint8).reshape(-1)
    if kind == 2:  # of the line above
        return line + above
    if kind not in (3, 4):
        raise ValueError(f"unknown filter {kind}")
    out, up = bytearray(line.tobytes()), above.tobytes()
    for i in range(len(out)):
        left = out[i - step] if i >= step else 0
        corner = up[i - step] if i >= step else 0
        out[i] = (out[i] + ((left + up[i]) // 2 if kind == 3 else _paeth(left, up[i], corner))) & 255
    return np.frombuffer(bytes(out), np.uint8)


def _check_size(width: int, height: int, pixel_bytes: int) -> None:
    if not (0 < width <= 65536 and 0 < height <= 65536 and width * height * pixel_bytes <= _MOST_BYTES):
        raise ValueError(f"{width} x {height} pixels: must be 1 to 65536 a side, and at most {_MOST_BYTES} bytes in all")


def _inflated(packed: bytes, size: int) -> bytes:
    """`size` bytes, however many a hostile file would give."""
    data = zlib.decompressobj().decompress(packed, size)
    if len(data) != size:
        raise ValueError(f"{len(data)} bytes where {size} are needed")
    return data


def read_png(path: Path) -> np.ndarray:
    """uint8 or uint16 of shape (height, width), or (height, width, channels) where there are several."""
    data = _read(path)
    if not data.startswith(b"\x89PNG\r\n\x1a\n"):
        raise InputError(f"{os.fspath(path)}: is not a PNG")
    try:
        width, height, bits, color, _, _, interlaced = struct.unpack(">IIBBBBB", data[16:29])
        if bits not in (8, 16) or color not in _PNG_CHANNELS or interlaced:
            raise ValueError("only 8 or 16 bits, without palette and interlacing, can be read")
        step = _PNG_CHANNELS[color] * bits // 8
        _check_size(width, height, step)
        packed, at = b"", 8
        while at < len(data):
            (length,) = struct.unpack(">I", data[at : at + 4])
            if data[at + 4 : at + 8] == b"IDAT":
                packed += data[at + 8 : at + 8 + length]
            at += 12 + length
        rows = np.frombuffer(_inflated(packed, height * (1 + width * step)), np.uint8).reshape(height, -1)
        pixels = np.empty((height, width * step), np.uint8)
        above = np.zeros(width * step, np.uint8)
        for y in range(height):
            above = pixels[y] = _unfiltered(int(rows[y, 0]), rows[y, 1:], above, step)
    except (ValueError, IndexError, OverflowError, struct.error, zlib.error) as error:
        raise InputError(f"{os.fspath(path)}: cannot be read: {error}") from error
    image = pixels.view(">u2").astype(np.uint16) if bits == 16 else pixels
    shape = (height, width) if _PNG_CHANNELS[color] == 1 else (height, width, _PNG_CHANNELS[color])
    return image.reshape(shape)


def _text(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(b"\0", at)
    text = data[at:end].decode("latin-1")
    if not text.isprintable():
        raise ValueError("a name holds control characters")
    return text, end + 1


def _exr_header(data: bytes) -> tuple[dict[str, bytes], int]:
    attributes, at = {}, 8
    while data[at] != 0:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack("<I", data[at : at + 4])
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _exr_channels(entry: bytes) -> list[tuple[str, np.dtype]]:
    channels, at = [], 0
    while entry[at] != 0:
        name, at = _text(entry, at)
        (kind,) = struct.unpack("<i", entry[at : at + 4])
        if entry[at + 8 : at + 16] != struct.pack("<ii", 1, 1):
            raise ValueError("subsampled channels cannot be read")
        channels.append((name, _EXR_TYPES[kind]))
        at += 16
    return channels


def _exr_unpacked(chunk: bytes, size: int) -> bytes:
    """Undoes OpenEXR's zip: deflated differences of bytes whose even ones come before the odd ones."""
    if len(chunk) == size:  # stored as it is, since packing made it no smaller
        return chunk
    steps = np.frombuffer(_inflated(chunk, size), np.uint8).copy()
    steps[1:] -= 128
    halves = np.add.accumulate(steps, dtype=np.uint8)
    joined, middle = np.empty(size, np.uint8), (size + 1) // 2
    joined[0::2], joined[1::2] = halves[:middle], halves[middle:]
    return joined.tobytes()


def read_exr(path: Path) -> dict[str, np.ndarray]:
    """The channels by name, each of shape (height, width): float32 (of half floats as well) or uint32."""
    data = _read(path)
    if not data.startswith(b"\x76\x2f\x31\x01"):
        raise InputError(f"{os.fspath(path)}: is not an EXR")
    try:
        version = struct.unpack("<I", data[4:8])[0]
        header, at = _exr_header(data)
        packing = header["compression"][0]
        if version & ~0x4FF or packing not in _EXR_LINES:
            raise ValueError("only scanlines in one part, without compression or zipped, can be read")
        channels = _exr_channels(header["channels"])
        left, top, right, bottom = struct.unpack("<4i", header["dataWindow"])
        width, height, lines = right - left + 1, bottom - top + 1, _EXR_LINES[packing]
        pixel_bytes = sum(kind.itemsize for _, kind in channels)
        _check_size(width, height, pixel_bytes)
        images = {name: np.empty((height, width), kind) for name, kind in channels}
        for first, offset in zip(range(0, height, lines), struct.unpack_from(f"<{-(-height // lines)}Q", data, at)):
            y, size = struct.unpack_from("<iI", data, offset)
            if y != top + first:
                raise ValueError(f"line {y} where {top + first} is needed")
            count = min(lines, height - first)
            rows = _exr_unpacked(data[offset + 8 : offset + 8 + size], count * width * pixel_bytes)
            place = 0
            for row in range(first, first + count):
                for name, kind in channels:
                    images[name][row] = np.frombuffer(rows, kind, width, place)
                    place += width * kind.itemsize
    except (ValueError, KeyError, IndexError, OverflowError, struct.error, zlib.error) as error:
        raise InputError(f"{os.fspath(path)}: cannot be read: {error}") from error
    return {name: image if image.dtype.kind == "u" else image.astype(np.float32) for name, image in images.items()}


def joined(channels: dict[str, np.ndarray], *names: str) -> np.ndarray:
    """Some channels of an EXR as one array of shape (height, width, channels)."""
    return np.stack([channels[name] for name in names], axis=-1)
