"""own_library.py FILE COPY STRIP PATCHELF: a copy of a shared library that is called COPY, for itself and for those that link it."""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path

SHT_DYNSYM, STB_WEAK, STB_GNU_UNIQUE = 11, 2, 10


def make_unique_symbols_weak(library: bytearray) -> int:
    """The loader merges symbols of the binding "unique" over all libraries of a process, whatever their versions. Weak ones stay inside."""
    if library[:6] != b"\x7fELF\x02\x01":
        raise SystemExit("own_library.py: expected a 64-bit little-endian ELF library")
    (sections,) = struct.unpack_from("<Q", library, 0x28)
    size, count = struct.unpack_from("<HH", library, 0x3A)
    changed = 0
    for section in range(sections, sections + size * count, size):
        _, kind, _, _, begin, length, _, _, _, entry = struct.unpack_from("<IIQQQQIIQQ", library, section)
        if kind != SHT_DYNSYM:
            continue
        for info in range(begin + 4, begin + length, entry):  # after the offset of the name
            if library[info] >> 4 == STB_GNU_UNIQUE:
                library[info] = STB_WEAK << 4 | library[info] & 0xF
                changed += 1
    return changed


def main(source: str, copy: str, strip: str, patchelf: str) -> None:
    unfinished = Path(copy).with_suffix(".part")
    unfinished.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, unfinished)
    unfinished.chmod(0o755)
    subprocess.run([strip, unfinished], check=True)  # before patchelf, whose output some versions of strip damage
    subprocess.run([patchelf, "--remove-rpath", "--set-soname", Path(copy).name, unfinished], check=True)
    content = bytearray(unfinished.read_bytes())
    make_unique_symbols_weak(content)
    unfinished.write_bytes(content)
    os.replace(unfinished, copy)


if __name__ == "__main__":
    main(*sys.argv[1:])
