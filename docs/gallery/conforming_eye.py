"""Makes conforming-eye.png: the orbit of our shapes as one mesh, cut in the middle, each tissue in a colour of its own.
    python3 docs/gallery/conforming_eye.py build/release/apps/palpate/palpate"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

# As in scenes/eye.json.
COLOURS = {"bone": [0.87, 0.83, 0.72], "fat": [0.95, 0.84, 0.5], "bulb": [0.93, 0.92, 0.89], "rectus": [0.72, 0.27, 0.23],
           "nerve": [0.82, 0.7, 0.3], "skin": [0.88, 0.68, 0.58]}
VIEW = {"name": "cut", "size": [960, 640], "when": "start", "cut": {"point": [0.1, 0, 0], "normal": [1, 0, 0]},
        "camera": {"position": [155, 12, 14], "target": [0, 12, -2]}}


def main(command):
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place)

        def palpate(*words):
            subprocess.run([command, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)

        palpate("generate", "eye-labels", "--out", "eye.seg.nrrd")
        palpate("mesh", "eye.seg.nrrd", "--conforming", "--rigid", "bone", "--relation", "slides", "--relation", "fat:bone=grown",
                "--relation", "skin:bone=grown", "--out", "eye")
        file = folder / "eye/scene.json"
        scene = json.loads(file.read_text())
        scene |= {"name": "orbit, one mesh of all tissues", "duration": scene["time_step"]}
        scene["output"]["views"] = [VIEW]
        for body in scene["bodies"]:
            body["color"] = COLOURS[body["name"].split("-")[0]]
        file.write_text(json.dumps(scene))
        palpate("run", "eye/scene.json", "--out", "results", "--quiet")
        shutil.copy(folder / "results/cut.png", pathlib.Path(__file__).parent / "conforming-eye.png")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve())
