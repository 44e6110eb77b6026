"""Which plate for this broken orbital floor, and does the answer depend on the mesh? Studies of scenes/orbit-repair.json.

    ./dev python examples/orbit_study.py plans FOLDER     two shapes of the plate at three places, tissue of three stiffnesses
    ./dev python examples/orbit_study.py plans FOLDER --head ct   the same with scenes/orbit-ct.json, whose plates are raised and lowered
    ./dev python examples/orbit_study.py meshes FOLDER    the repair with four meshes of the same label map; the fracture also with smoothed tets
    ./dev python examples/orbit_study.py meshes FOLDER --head ct   the same with the label map of the CT

Each writes a table (.csv, .json) and a chart (.png) to FOLDER. Finished runs are kept there: a study that was interrupted
continues where it was. docs/orbit.md shows what comes out.
"""

import argparse
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys

import palpate

ROOT = pathlib.Path(__file__).resolve().parents[1]
SCENES = {"synthetic": ROOT / "scenes" / "orbit-repair.json", "ct": ROOT / "scenes" / "orbit-ct.json"}
CT_MESHES = ROOT / "build" / "ct" / "orbit"
PLATE = ["--size", "18,20", "--thickness", 0.5]  # mm; as in the scene
SHAPES = {"bent": [], "flat": ["--flat"]}
PLACES = {"planned": (-2.0, 7.0), "4 mm forward": (-2.0, 3.0), "4 mm lateral": (2.0, 7.0)}
RISES = {"planned": 0.0, "1 mm higher": 1.0, "1 mm lower": -1.0}  # mm, of the plates of the CT: they fit into the hole, and reach no other place
TETS = {"synthetic": {"coarse": 12500, "middle": 25000, "fine": 50000, "finest": 100000},
        "ct": {"coarse": 15000, "middle": 31000, "fine": 60000, "finest": 120000}}  # of all tissues
LAST = {"synthetic": "release", "ct": "repair"}  # the stage after which the repair is judged
OFF = ("globe_off", "globe off its place, mm", 1, 0.05)  # column, label, factor of its unit, least end of its axis
CHARTED = {"synthetic": [OFF, ("herniated", "herniated tissue, ml", 1e-3, 0.1)], "ct": [OFF, ("orbit_larger", "orbit larger by, ml", 1e-3, 0.05)]}
PARTS = ["repair", "fracture"]  # of the study of meshes: the scene as it is, and its fracture with smoothed fat
BORDER, HOLE = 1.0, 1.4  # mm, of the part `fracture`, middle mesh: triangles at the border of the hole, and over it
PRESSURE = 530.0  # Pa, 4 mmHg, of the plans and of the part `fracture`: with the scene's 1000 Pa, fat of half the stiffness is torn
RAMP = 0.3  # s, of the pressure of the part `fracture`
SOFT, BULB = "fat", 1  # the body; the label of its region


def find_command():
    """The palpate command: of PALPATE_COMMAND, on the PATH, or in the build of this clone."""
    found = os.environ.get("PALPATE_COMMAND") or shutil.which("palpate") or ROOT / "build/release/apps/palpate/palpate"
    if not pathlib.Path(found).exists():
        sys.exit(f"orbit_study.py: no palpate command (looked at PALPATE_COMMAND, the PATH and {found})")
    return str(found)


def call(*arguments):
    subprocess.run([find_command(), *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


def of_ct(name):
    """A file that is made from the CT."""
    file = CT_MESHES / name
    if not file.exists():
        sys.exit(f"orbit_study.py: no {file}: './dev run scenes/orbit-ct.json --steps 1' makes it from the CT")
    return file


def make_plate(folder, shape, place):
    """A plate of this shape that rests on the floor at this place; its file."""
    x, y = PLACES[place]
    file = folder / "plates" / f"{shape}-{place.replace(' ', '-')}.vtu"
    file.parent.mkdir(parents=True, exist_ok=True)
    call("generate", "orbit-plate", f"--at={x},{y}", *PLATE, *SHAPES[shape], "--out", file)
    return file


def plate_of(folder, head, shape, place):
    """Which plate is put where: values of a run."""
    if head == "synthetic":
        return {"plate": str(make_plate(folder, shape, place))}
    return {"plate": str(of_ct(f"plate-{shape}.mesh")), "rise": RISES[place]}


def labels_of(folder, head):
    """The file of the label map."""
    if head == "synthetic":
        labels = folder / "orbit.seg.nrrd"
        call("generate", "orbit-labels", "--out", labels)
        return labels
    return of_ct("organs.seg.nrrd")


def make_meshes(folder, head, part, fineness):
    """The bodies of the label map with so many tets; the folder of their files. All sizes scale with the tets."""
    out = folder / "meshes" / f"{part}-{fineness}"
    scale = (TETS[head]["middle"] / TETS[head][fineness]) ** (1 / 3)
    sizes = ["--size", f"floor:fragment={BORDER * scale:.3g}", "--size", f"fat:fragment={HOLE * scale:.3g}"] if part == "fracture" else []
    call("mesh", labels_of(folder, head), "--conforming", "--rigid", "bone", "--rigid", "floor", "--rigid", "fragment", "--relation",
         "fat:floor=slides", "--relation", "fat:fragment=slides", "--tets", TETS[head][fineness], *sizes, "--out", out, "--replace",
         "--quiet")
    return out


def change(scene, values):
    """Another plate and pressure, tissue so many times as stiff. A retractor lifts stiffer tissue with more force."""
    bodies = {body["name"]: body for body in scene["bodies"]}
    bodies["plate"]["mesh"] = values["plate"]
    if "rise" in values:
        (insert,) = [stage for stage in scene["stages"] if stage["name"] == "insert"]
        insert["move"][0]["motion"]["keyframes"][-1]["translate"][2] += values["rise"]
    bodies[SOFT]["material"]["young_modulus"] *= values["stiffness"]
    changes = [change_of_loads for stage in scene["stages"] for change_of_loads in stage.get("loads", ())]
    for load in [load for loaded in [bodies[SOFT], *changes] for load in loaded["loads"]]:
        load["pressure"] = values["stiffness"] * load["pressure"] if load["pressure"] > 0 else -values["pressure"]


def change_mesh(scene, values):
    """The scene with other meshes; or its fracture with these, smoothed fat and a pressure that rises slowly."""
    for body in scene["bodies"]:
        if body["name"] != "plate":
            body["mesh"] = os.path.join(os.path.dirname(values["mesh"]), f"{body['name']}.vtu")
    if values["part"] == "repair":
        return
    scene["bodies"] = [body for body in scene["bodies"] if body["name"] != "plate"]
    scene["outcomes"] = [outcome for outcome in scene["outcomes"] if not outcome["name"].startswith("plate")]
    soft = next(body for body in scene["bodies"] if body["name"] == SOFT)
    soft["material"]["elements"] = "smoothed"
    for region in soft["regions"]:
        region["material"]["elements"] = "linear" if region["label"] == BULB else "smoothed"
    (load,) = soft["loads"]
    load["pressure"] = -values["pressure"]
    load["ramp"] = {"times": [0, RAMP], "factors": [0, 1]}
    scene.pop("duration", None)  # of all stages
    scene["stages"] = [stage for stage in scene["stages"] if stage["name"] in ("intact", "fracture")]
    scene["stages"][1]["loads"] = [{"body": SOFT, "loads": [load]}]


def tets(simulation):
    """Besides the outcomes: how fine the soft body is."""
    body = simulation.bodies[SOFT]
    return {"tets": body.tets.stop - body.tets.start}


def runs(scene, folder, samples, workers, apply):
    threads = max(1, (os.cpu_count() or 1) // (workers or os.cpu_count() or 1))
    rows = palpate.sweep_rows(scene, samples, apply=apply, measure=tets, folder=folder, workers=workers, threads=threads, retry_failed=True)
    for row in rows:
        if row["status"] != "done":
            print(f"FAILED {row['error']}", file=sys.stderr)
    return rows


def study_plans(folder, workers, head, shapes, places, factors):
    samples = [{"shape": shape, "place": place, "stiffness": factor, "pressure": PRESSURE, **plate_of(folder, head, shape, place)}
               for shape in shapes for place in places for factor in factors]
    rows = runs(SCENES[head], folder, samples, workers, change)
    for row in rows:
        if row["status"] == "done":
            row["orbit_larger"] = row["orbit_volume"] - row["intact.orbit_volume"]
    ranked = rank(rows)
    write(folder / "plans", rows, {"ranked": ranked})
    print(f"{'plan':22} {'globe off, mm':>18} {'orbit larger by, ml':>20} {'herniated, ml':>14} {'plate, N':>9}  remarks")
    for entry in ranked:
        off, larger = entry["globe_off"], [volume / 1000 for volume in entry["orbit_larger"]]
        print(f"{entry['plan']:22} {off[0]:8.3f} to {off[1]:6.3f} {larger[0]:10.3f} to {larger[1]:6.3f} {entry['herniated'] / 1000:14.3f} "
              f"{entry['plate_force'] / 1e6:9.3f}  {entry['remarks']}")
    chart_plans(folder / "plans.png", ranked, rows, CHARTED[head])


def remarks_of(row):
    """What speaks against a run, a line each."""
    if row["status"] != "done":
        return ["a run failed"]
    factor = f"fat {row['stiffness']:g}"
    return ([row["warnings"]] * bool(row["warnings"]) + [f"{factor}: {row['inverted_tets']} inverted tets"] * (row["inverted_tets"] > 0)
            + [f"{factor}: {row['steps_not_converged']} steps not converged"] * (row["steps_not_converged"] > 0))


def rank(rows):
    """Plans by how far the globe is from where it was, the mean over stiffnesses; plans with remarks last. Ranges are over stiffnesses."""
    plans = {}
    for row in rows:
        plans.setdefault(f"{row['shape']}, {row['place']}", []).append(row)
    ranked = []
    for name, runs_of_plan in plans.items():
        done = [row for row in runs_of_plan if row["status"] == "done"]
        remarks = sorted({remark for row in runs_of_plan for remark in remarks_of(row)})
        off = [row["globe_off"] for row in done] or [float("inf")]
        larger = [row["orbit_larger"] for row in done] or [float("inf")]
        ranked.append({"plan": name, "mean": sum(off) / len(off), "globe_off": [min(off), max(off)], "orbit_larger": [min(larger), max(larger)],
                       "herniated": max((row["herniated"] for row in done), default=float("inf")),
                       "plate_force": max((row["plate_force"] for row in done), default=float("inf")), "remarks": "; ".join(remarks)})
    return sorted(ranked, key=lambda plan: (bool(plan["remarks"]), plan["mean"]))


def study_meshes(folder, workers, head, names, parts):
    last = LAST[head]
    samples = [{"part": part, "fineness": name, "mesh": str(make_meshes(folder, head, part, name) / f"{SOFT}.vtu"), "pressure": PRESSURE}
               for part in parts for name in names]
    rows = runs(SCENES[head], folder, samples, workers, change_mesh)
    done = [row for row in rows if row["status"] == "done"]
    for row in done:
        for stage in ("fracture", last):
            for name in ("herniated", "orbit_volume"):
                if f"{stage}.{name}" in row:
                    row[f"{stage}.{name}_change"] = row[f"{stage}.{name}"] - row[f"intact.{name}"]
    write(folder / "meshes", rows, {})
    after = ["globe_down", "globe_back", "globe_off", "orbit_volume_change"]
    fracture = [f"fracture.{name}" for name in [*after, "herniated_change"]]
    plate = ["plate_force", "plate_area"] if head == "synthetic" else ["plate_force"]
    groups = [("after the repair", "repair", [f"{last}.{name}" for name in [*after, *plate]]),
              ("after the fracture, linear tets", "repair", fracture), ("after the fracture, smoothed fat", "fracture", fracture)]
    for title, part, shown in groups:
        own = [row for row in done if row["part"] == part]
        if not own:
            continue
        print(f"\n{title:20}" + " ".join(f"{row['fineness']:>12}" for row in own) + "  finer to finest")
        for name in ["tets", "most_inverted_tets", "steps_not_converged", *shown]:
            difference = f"{100 * (own[-2][name] / own[-1][name] - 1):+12.1f} %" if len(own) > 1 and name in shown and own[-1][name] else ""
            print(f"{name.split('.')[-1]:20}" + " ".join(f"{row[name]:12.5g}" for row in own) + difference)
    chart_meshes(folder / "meshes.png", done, groups)


def write(stem, rows, more):
    names = list(dict.fromkeys(name for row in rows for name in row if name != "traceback"))
    with open(stem.with_suffix(".csv"), "w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, names, extrasaction="ignore")
        table.writeheader()
        table.writerows(rows)
    stem.with_suffix(".json").write_text(json.dumps({"rows": rows, **more}, indent=1), encoding="utf-8")


def axes(width, height, columns):
    """matplotlib's, or None where it is not installed: the tables do without."""
    try:
        import matplotlib
    except ImportError:
        print("orbit_study.py: no chart without matplotlib: pip install 'palpate[plot]'", file=sys.stderr)
        return None
    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot.subplots(1, columns, figsize=(width, height), layout="constrained", squeeze=False)


def chart_plans(file, ranked, rows, shown):
    made = axes(9.0, 0.5 * len(ranked) + 1.4, 2)
    if made is None:
        return
    figure, (places,) = made
    colors = {0.5: "#56b4e9", 1.0: "#000000", 2.0: "#d55e00"}
    for axis, (column, label, unit, least) in zip(places, shown):
        for height, plan in enumerate(reversed(ranked)):
            own = [row for row in rows if row["status"] == "done" and f"{row['shape']}, {row['place']}" == plan["plan"]]
            values = [unit * row[column] for row in own]
            if values:
                axis.plot([min(values), max(values)], [height, height], color="0.75", linewidth=3, zorder=1)
            for row, value in zip(own, values):
                axis.scatter(value, height, s=36, color=colors.get(row["stiffness"], "0.4"), zorder=2,
                             label=f"fat, {row['stiffness']:g} times as stiff" if height == 0 else None)
        axis.set_yticks(range(len(ranked)), [plan["plan"] for plan in reversed(ranked)] if axis is places[0] else [])
        axis.set_xlabel(label)
        low, high = axis.get_xlim()
        negative = any(row[column] < 0 for row in rows if row["status"] == "done")
        axis.set_xlim(low if negative else 0, max(least, high))
        axis.axvline(0, color="0.5", linewidth=0.8, zorder=0)
        axis.grid(axis="x", color="0.9")
    places[0].legend(frameon=False, fontsize=8)
    figure.savefig(file, dpi=120)


def chart_meshes(file, rows, groups):
    made = axes(11.0, 3.6, len(groups))
    if made is None:
        return
    figure, (places,) = made
    for axis, (title, part, shown) in zip(places, groups):
        own = [row for row in rows if row["part"] == part]
        for name in shown:
            if own and own[-1][name]:
                axis.plot([row["tets"] / 1000 for row in own], [row[name] / own[-1][name] for row in own], marker="o",
                          label=name.split(".")[-1])
        axis.axhspan(0.95, 1.05, color="0.92", zorder=0)
        axis.set_title(title, fontsize=10)
        axis.set_xlabel("thousand tets of the soft tissue")
        axis.set_ylim(0.5, 1.3)
        axis.legend(frameon=False, fontsize=8, loc="lower right", ncols=2)
    places[0].set_ylabel("outcome over that of the finest mesh")
    figure.savefig(file, dpi=90)


def main():
    parser = argparse.ArgumentParser(description="Studies of the repair of an orbital floor.")
    parser.add_argument("study", choices=["plans", "meshes"])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--workers", type=int, default=None, help="processes; default: one a core")
    parser.add_argument("--head", choices=SCENES, default="synthetic")
    parser.add_argument("--shapes", nargs="+", choices=SHAPES, default=list(SHAPES))
    parser.add_argument("--places", nargs="+", choices=[*PLACES, *list(RISES)[1:]], help="default: all of this head")
    parser.add_argument("--stiffness", nargs="+", type=float, default=[0.5, 1.0, 2.0], help="of the fat, factors")
    parser.add_argument("--meshes", nargs="+", choices=TETS["ct"], default=list(TETS["ct"]))
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS, help="of the study of meshes")
    given = parser.parse_args()
    folder = given.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    if given.study == "plans":
        known = PLACES if given.head == "synthetic" else RISES
        if unknown := [place for place in given.places or () if place not in known]:
            parser.error(f"--places: found '{unknown[0]}', expected one of: {', '.join(known)}")
        study_plans(folder, given.workers, given.head, given.shapes, given.places or list(known), given.stiffness)
    else:
        study_meshes(folder, given.workers, given.head, given.meshes, given.parts)


if __name__ == "__main__":
    main()
