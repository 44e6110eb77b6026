"""Builds the meshes of a CT scene: prepare.py SCENE SOURCE FOLDER PALPATE.

Skips what is there already for the same inputs. Everything is written beside and renamed; a folder that is whole has a stamp.
"""

import hashlib
import os
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).parent


def stamp_of(source, palpate):
    """Of all that the meshes depend on."""
    digest = hashlib.sha256()
    files = sorted(source.iterdir()) if source.is_dir() else [source]
    for file in [*files, *sorted(HERE.glob("*.py")), palpate.with_name("palpate-mesh")]:
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()


def write_medit(path, points, tets):
    """Points and tets as a Medit mesh."""
    lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(points))]
    lines += [f"{x:.6f} {y:.6f} {z:.6f} 0" for x, y, z in points]
    lines += ["Tetrahedra", str(len(tets)), *(" ".join(str(c + 1) for c in tet) + " 0" for tet in tets), "End", ""]
    path.write_text("\n".join(lines))


def prepare(scene, source, folder, palpate):
    import eye
    import orbit
    import skull

    make = {"eye": eye.make, "orbit": orbit.make, "skull": skull.make_cranium, "jaw": skull.make_headsq}[scene]
    work = folder.with_name(f"{folder.name}.{os.getpid()}")
    work.mkdir(parents=True)
    try:
        flags = make(source, work, write_medit)
        subprocess.run([palpate, "mesh", work / "organs.seg.nrrd", "--out", work, "--quiet", *flags], check=True, stdout=subprocess.DEVNULL)
        (work / "stamp").write_text(stamp_of(source, palpate))
        shutil.rmtree(folder, ignore_errors=True)
        work.rename(folder)
    finally:
        shutil.rmtree(work, ignore_errors=True)


def main(scene, source, folder, palpate):
    source, folder, palpate = pathlib.Path(source), pathlib.Path(folder), pathlib.Path(palpate)
    stamp = folder / "stamp"
    if stamp.exists() and stamp.read_text() == stamp_of(source, palpate):
        return 0
    try:
        print(f"scenes/ct: building the organs of {folder} from {source}", file=sys.stderr)
        prepare(scene, source, folder, palpate)
    except subprocess.CalledProcessError:
        return 1  # it has said why
    except KeyboardInterrupt:
        print("scenes/ct: interrupted; nothing was written", file=sys.stderr)
        return 1
    except (OSError, ValueError, KeyError, AssertionError, RuntimeError) as error:
        print(f"scenes/ct: {source}: {error}".replace("\n", " "), file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
