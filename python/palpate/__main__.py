"""python -m palpate: the palpate command, where the package has it."""

from __future__ import annotations

import os
import pathlib
import sys


def command() -> pathlib.Path | None:
    """The command inside the package. Wheels of ./dev wheel have it, those that pip builds from source do not."""
    file = pathlib.Path(__file__).parent / "bin" / "palpate"
    return file if file.is_file() else None


def main() -> None:
    """Replaces this process by the command, with its arguments."""
    file = command()
    if file is None:
        sys.exit("palpate: error: this package was built without the palpate command; a wheel of './dev wheel' has it, "
                 "and 'cmake --install' in a clone installs it")
    os.execv(file, ["palpate", *sys.argv[1:]])


if __name__ == "__main__":
    main()
