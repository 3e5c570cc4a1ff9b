#!/usr/bin/env python3
"""Processor seconds of compiling and linking from nothing, without the cache of the compiler.

    bench/compile_time.py [--parts product tests benchmarks] [--preset release] [--unity 8] [--jobs 2] [--folder FOLDER]

A line on stdout for each part, as it is done. A later part does not pay for the layers that an earlier one compiled.
Other work on the machine lengthens the wall time more than the processor time.
"""

import argparse
import os
import pathlib
import sys
import tempfile

from runs import ROOT, measure_run

PARTS = {
    "product": ["stiction_cli", "stiction_package", "stiction_stub"],
    "tests": [f"tests/{file.parent.name}/all" for file in sorted((ROOT / "tests").glob("*/CMakeLists.txt"))],
    "benchmarks": ["bench/all"],
}


def measure(arguments: argparse.Namespace, folder: pathlib.Path) -> int:
    cmake = ["cmake", "-S", ROOT, "-B", folder, "--preset", arguments.preset, *([f"-DSTICTION_UNITY={arguments.unity}"] if arguments.unity is not None else [])]
    for name, words in [
        ("configuration", cmake),
        *((part, ["cmake", "--build", folder, "-j", arguments.jobs, "--target", *PARTS[part]]) for part in arguments.parts),
    ]:
        run = measure_run(words)
        if run.code:
            print(run.text[-4000:], file=sys.stderr)
            return 2
        print(f"{name:14}{run.processor_s:8.0f} processor s{run.wall_s:8.0f} s", flush=True)
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS), help="in this order")
    parser.add_argument("--preset", default="release")
    parser.add_argument("--unity", type=int, metavar="N", help="source files in one compilation, 0 for each alone; default: that of the preset")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--folder", type=pathlib.Path, help="an empty or new folder, which stays; default: a temporary one")
    arguments = parser.parse_args()
    os.environ["CCACHE_DISABLE"] = "1"
    if arguments.folder:
        if arguments.folder.exists() and any(arguments.folder.iterdir()):
            parser.error(f"--folder: got {arguments.folder}, which is not empty, expected an empty or new folder")
        return measure(arguments, arguments.folder.resolve())
    with tempfile.TemporaryDirectory() as folder:
        return measure(arguments, pathlib.Path(folder))


if __name__ == "__main__":
    sys.exit(main())
