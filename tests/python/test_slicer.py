"""slicer/PalpatePlan without Slicer: a stand-in for its objects, the real command, VTK's own readers as oracles."""

import json
import os
import pathlib
import sys
import time
import types

import numpy as np
import pytest

vtk = pytest.importorskip("vtk")
import slicer_stand_in as stand_in  # noqa: E402


@pytest.fixture
def module(root, monkeypatch, tmp_path):
    """The module, loaded like in Slicer: its folder is on the path."""
    before = dict(sys.modules)
    monkeypatch.syspath_prepend(str(root / "slicer" / "PalpatePlan"))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    slicer = stand_in.install(dict(os.environ))
    import PalpatePlan

    yield types.SimpleNamespace(module=PalpatePlan, slicer=slicer)
    sys.modules.clear()
    sys.modules.update(before)


def boxes():
    """A soft box (1) on a bone (2), and a lump (3) in the soft one; voxels (k, j, i)."""
    masks = [np.zeros((16, 14, 18), bool) for _ in range(3)]
    masks[0][7:13, 3:11, 3:15] = True
    masks[1][3:7, 3:11, 3:15] = True
    masks[2][9:12, 5:9, 6:10] = True
    return [("fat", (0.9, 0.8, 0.4), masks[0]), ("bone", (0.9, 0.9, 0.8), masks[1]), ("lump", (0.7, 0.3, 0.2), masks[2])]


def finished(process):
    end = time.monotonic() + 120
    while not process.done and time.monotonic() < end:
        time.sleep(0.02)
    assert process.code == 0, process.lines()
    return process


def test_from_a_segmentation_to_models_over_time(module, command, tmp_path):
    plan, slicer = module.module.plan, module.slicer
    node = stand_in.SegmentationNode(boxes())
    tissues = module.module.nodes.tissues_of(node)
    assert [tissue.name for tissue in tissues] == ["fat", "bone", "lump"]
    tissues[0].young_modulus, tissues[1].rigid, tissues[2].young_modulus = 3e3, True, 4e4
    wanted = plan.Plan(tissues, plan.relations_of("fat : bone = slides\n"), tets=1500)
    logic = module.module.PalpatePlanLogic()
    logic.folder = tmp_path
    report = json.loads(finished(logic.start_meshing(command, node, wanted)).output)
    assert report["space"] == "RAS" and slicer.mrmlScene.nodes == []
    additions = tmp_path / "more.json"
    additions.write_text(json.dumps({"gravity": [0, 0, -9810], "duration": 0.05, "output": {"every": 1},
                                     "outcomes": [{"name": "sag", "displacement": {"body": "fat", "along": [0, 0, -1]}}]}))
    scene = json.loads(logic.finish_scene(wanted, str(additions)).read_text())
    fat = next(body for body in scene["bodies"] if body["name"] == "fat")
    assert fat["material"]["young_modulus"] == 3e3 and fat["regions"][0]["material"]["young_modulus"] == 4e4
    assert fat["material"]["density"] == 1e-3 and fat["color"] == [0.9, 0.8, 0.4]
    finished(logic.start_run(command))
    found = logic.show(wanted)
    assert found.warnings == [] and [name for name, _ in module.module.results.outcome_rows(found)] == ["sag"]
    browser = slicer.modules.sequences.active[0]
    assert {proxy.GetName() for _, proxy in browser.pairs} == {"fat", "bone"}
    for sequence, proxy in browser.pairs:
        assert sequence.index == ["time", "s"] and sequence.GetNumberOfDataNodes() == 6
        assert [float(sequence.GetNthIndexValue(i)) for i in range(6)] == pytest.approx(np.arange(6) / 100)
        mask = boxes()[["fat", "bone"].index(proxy.GetName())][2]
        bounds = np.array(sequence.GetNthDataNode(0).GetPolyData().GetBounds()).reshape(3, 2)
        places = np.argwhere(mask)[:, ::-1]  # (i, j, k) are RAS in mm
        assert np.abs(bounds - np.stack([places.min(0) - 0.5, places.max(0) + 0.5], 1)).max() < 0.6
        assert proxy.GetDisplayNode().color == ((0.9, 0.8, 0.4) if proxy.GetName() == "fat" else (0.9, 0.9, 0.8))
    lowest = [pair[0].GetNthDataNode(5).GetPolyData().GetBounds()[5] for pair in browser.pairs if pair[1].GetName() == "fat"]
    first = [pair[0].GetNthDataNode(0).GetPolyData().GetBounds()[5] for pair in browser.pairs if pair[1].GetName() == "fat"]
    assert lowest < first  # it sags


def test_what_cannot_be_is_told_in_one_line(module, command, tmp_path):
    plan, nodes = module.module.plan, module.module.nodes
    soft, bone = plan.Tissue("fat"), plan.Tissue("bone", rigid=True)
    for wanted, part in [
        (plan.Plan([]), "no segment"), (plan.Plan([bone]), "all segments are rigid"), (plan.Plan([soft, soft]), "another segment"),
        (plan.Plan([plan.Tissue("fat", young_modulus=0)]), "> 0"),
        (plan.Plan([soft, bone], [plan.Relation("fat", "skin")]), "no segment 'skin'"),
        (plan.Plan([soft, bone], [plan.Relation("fat", "bone", "glued")]), "'glued'"),
        (plan.Plan([soft, bone], [plan.Relation("fat", "bone", "open")]), "gap"),
    ]:
        with pytest.raises(ValueError, match=part):
            plan.check(wanted)
    with pytest.raises(ValueError, match="expected A : B"):
        plan.relations_of("fat bone slides")
    with pytest.raises(ValueError, match="harden"):
        nodes.export_label_map(module.slicer, stand_in.SegmentationNode(boxes(), transform=object()), tmp_path / "a.nrrd")
    with pytest.raises(ValueError, match="could not export"):
        nodes.export_label_map(module.slicer, stand_in.SegmentationNode([]), tmp_path / "a.nrrd")
    assert module.slicer.mrmlScene.nodes == []
    (tmp_path / "frames.pvd").write_text("<VTKFile>")
    with pytest.raises(ValueError, match="frames.pvd"):
        module.module.results.read_frames(tmp_path / "frames.pvd")
    failed = module.module.process.Process([command, "mesh", "no.nrrd"])
    while not failed.done:
        time.sleep(0.01)
    assert failed.code == 2 and "no such file" in failed.lines()[0]


def test_a_program_that_runs_can_be_cancelled(module):
    started = module.module.process.Process([sys.executable, "-c", "import time; print('on', flush=True); time.sleep(60)"])
    assert not started.done
    started.cancel()
    end = time.monotonic() + 20
    while not started.done and time.monotonic() < end:
        time.sleep(0.01)
    assert started.done and started.code != 0


def test_files_of_the_module_stand_where_slicer_looks(root):
    """A scripted module is FOLDER/NAME.py with a class NAME; nothing of its library imports slicer, qt or vtk."""
    folder = root / "slicer" / "PalpatePlan"
    text = (folder / "PalpatePlan.py").read_text()
    for name in ("PalpatePlan", "PalpatePlanWidget", "PalpatePlanLogic"):
        assert f"class {name}(ScriptedLoadableModule" in text
    for file in pathlib.Path(folder / "PalpatePlanLib").glob("*.py"):
        assert not any(line.startswith(("import slicer", "import qt", "import vtk", "from slicer")) for line in file.read_text().splitlines())
