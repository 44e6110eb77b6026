"""What edge contacts cost: instructions and processor time of detections with and without them.

    python3 bench/edges_cost.py PROGRAM [--steps N] [--keep FOLDER] [SCENE...]

PROGRAM is palpate-bench-detections of a build. The positions of all detections in the first N (60) steps of a scene
are stored. A new detector detects them again with edge contacts, another one without, under valgrind's callgrind. The
first detection also chooses the size of cells; one ratio of instructions is without it. The ratio of times is that of
the medians of 15 runs of each, alternately, with the best SIMD target of the processor. The hash is of all edge
contacts. --keep keeps positions and counts in a folder; positions that are there are used again. SCENE is a file, with
changes after it ("scenes/stacking.json contact.edge_contacts=true").
"""

import argparse
import pathlib
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = ["scenes/eye.json", "scenes/skull.json", "../shared/data/rough/pile-1MPa-5ms.json",
          "scenes/stacking.json contact.edge_contacts=true", "examples/scenes/fold.json",
          "../shared/data/rough/crossed-bars-5.json"]


def run(command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True, cwd=ROOT)


def totals(file):
    return int(re.search(r"^totals: (\d+)", file.read_text(), re.MULTILINE).group(1)) / 1e6


def counted(program, mode, scene, changes, positions, out):
    """Millions of instructions: of the first detection, of the others; and what the program prints."""
    done = run(["valgrind", "--tool=callgrind", "--instr-atstart=no", "--collect-atstart=no",
                f"--callgrind-out-file={out}", program, mode, scene, positions, *changes])
    return totals(out.with_name(out.name + ".1")), totals(out), done.stdout.strip()


def row(program, words, steps, folder):
    """A line of the table."""
    scene, *changes = words.split()
    name = pathlib.Path(scene).stem
    positions = folder / f"{name}.positions"
    if not positions.exists():
        run([program, "record", steps, scene, positions, *changes])
    first, others, said = {}, {}, ""
    for mode in ("without", "with"):
        first[mode], others[mode], said = counted(program, mode, scene, changes, positions, folder / f"{name}.{mode}")
    timed = run([program, "times", scene, positions, *changes]).stdout
    a, b = (first[mode] + others[mode] for mode in ("without", "with"))
    return (f"| {words} | {said.split()[0]} | {a:.1f} | {b:.1f} | {b / a:.2f} | {others['with'] / others['without']:.2f} "
            f"| {float(timed.split()[-1]):.2f} | {said.split()[-1]} |")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--keep", type=pathlib.Path)
    asked = parser.parse_intermixed_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = asked.keep or pathlib.Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        print("| scene | detections | without edge contacts | with edge contacts | ratio | without the first | times | hash |")
        print("|---|---:|---:|---:|---:|---:|---:|---|", flush=True)
        for words in asked.scenes:
            print(row(asked.program.resolve(), words, asked.steps, folder.resolve()), flush=True)


if __name__ == "__main__":
    main()
