"""3D Slicer's module PalpatePlan: from a segmentation to what tissue does, with the command `palpate`.

Widgets only; what they do is in PalpatePlanLib, which is tested without Slicer.
"""

import json
import os
import pathlib
import shutil
import tempfile

import ctk
import qt
import slicer
import vtk
from slicer.ScriptedLoadableModule import ScriptedLoadableModule, ScriptedLoadableModuleLogic, ScriptedLoadableModuleWidget

from PalpatePlanLib import nodes, plan, process, results


class PalpatePlan(ScriptedLoadableModule):
    """What the module selector of Slicer shows."""

    def __init__(self, parent):
        ScriptedLoadableModule.__init__(self, parent)
        self.parent.title = "Palpate: plan with soft tissue"
        self.parent.categories = ["Simulation"]
        self.parent.dependencies = ["Segmentations", "Sequences"]
        self.parent.contributors = ["Palpate"]
        self.parent.helpText = ("Meshes a segmentation, runs a scene of it with the command palpate, and shows the bodies over time. "
                                "See slicer/README.md and docs/orbit.md of Palpate.")
        self.parent.acknowledgementText = ""


class PalpatePlanLogic(ScriptedLoadableModuleLogic):
    """One study: a folder with the label map, meshes, scene and results."""

    def __init__(self):
        ScriptedLoadableModuleLogic.__init__(self)
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="palpate-"))

    def start_meshing(self, command, segmentation_node, wanted):
        """Writes the label map and starts `palpate mesh`. Raises ValueError or OSError."""
        plan.check(wanted)
        label_map, labels = self.folder / "labels.nrrd", self.folder / "labels.txt"
        nodes.export_label_map(slicer, segmentation_node, label_map)
        labels.write_text(plan.label_descriptions(wanted.tissues), encoding="utf-8")
        arguments = plan.mesh_arguments(wanted, label_map, labels, self.folder / "mesh")
        return process.Process([command, *arguments], slicer.util.startupEnvironment())

    def finish_scene(self, wanted, additions):
        """Gives the scene of the meshes its materials, and what a file of the user adds (stages, outcomes, a plate)."""
        file = self.folder / "mesh" / "scene.json"
        scene = plan.with_materials(json.loads(file.read_text(encoding="utf-8")), wanted.tissues)
        if additions:
            scene = plan.merged(scene, json.loads(pathlib.Path(additions).read_text(encoding="utf-8")))
        file.write_text(json.dumps(scene, indent=1), encoding="utf-8")
        return file

    def start_run(self, command):
        """Starts `palpate run` with a page of the run."""
        arguments = ["run", str(self.folder / "mesh" / "scene.json"), "--report", "--out", str(self.folder / "results")]
        return process.Process([command, *arguments], slicer.util.startupEnvironment())

    def show(self, wanted):
        """Brings the results into the scene; returns them."""
        found = results.read_results(self.folder / "results")
        colors = {tissue.name: tissue.color for tissue in wanted.tissues if tissue.color is not None}
        slicer.modules.sequences.setToolBarActiveBrowserNode(nodes.show_results(slicer, vtk, found, colors))
        return found


class PalpatePlanWidget(ScriptedLoadableModuleWidget):
    """Segmentation, materials, relations; a button that meshes and runs; a log."""

    def setup(self):
        ScriptedLoadableModuleWidget.setup(self)
        self.logic = PalpatePlanLogic()
        self.process = None
        self.timer = qt.QTimer()
        self.timer.setInterval(200)
        self.timer.connect("timeout()", self.onTimer)
        box = ctk.ctkCollapsibleButton()
        box.text = "Plan"
        self.layout.addWidget(box)
        form = qt.QFormLayout(box)
        self.addInputs(form)
        self.addTables(form)
        self.addButtons(form)
        self.layout.addStretch(1)

    def cleanup(self):
        self.onCancel()

    def addInputs(self, form):
        self.selector = slicer.qMRMLNodeComboBox()
        self.selector.nodeTypes = ["vtkMRMLSegmentationNode"]
        self.selector.addEnabled = False
        self.selector.removeEnabled = False
        self.selector.noneEnabled = True
        self.selector.setMRMLScene(slicer.mrmlScene)
        self.selector.connect("currentNodeChanged(vtkMRMLNode*)", self.onSegmentation)
        form.addRow("Segmentation", self.selector)
        self.command = qt.QLineEdit(os.environ.get("PALPATE_COMMAND") or shutil.which("palpate") or "palpate")
        form.addRow("Command palpate", self.command)
        self.additions = ctk.ctkPathLineEdit()
        self.additions.setToolTip("A JSON file with keys of a scene: stages, outcomes, bodies such as a plate; may be empty")
        form.addRow("Added to the scene", self.additions)
        self.tets = qt.QSpinBox()
        self.tets.setRange(1000, 500000)
        self.tets.setValue(20000)
        form.addRow("Tets of the mesh", self.tets)
        self.gap = qt.QDoubleSpinBox()
        self.gap.setRange(0.0, 5.0)
        form.addRow("Gap of 'open', mm", self.gap)

    def addTables(self, form):
        self.tissues = qt.QTableWidget(0, 5)
        self.tissues.setHorizontalHeaderLabels(["segment", "rigid", "E, Pa", "Poisson's ratio", "density, kg/m3"])
        form.addRow("Tissues", self.tissues)
        self.relations = qt.QPlainTextEdit()
        self.relations.setToolTip("One a line: A : B = slides, or open, or grown. All other pairs are grown together.")
        form.addRow("Relations", self.relations)

    def addButtons(self, form):
        self.run = qt.QPushButton("Mesh, run and show")
        self.run.connect("clicked(bool)", self.onRun)
        form.addRow(self.run)
        self.cancel = qt.QPushButton("Cancel")
        self.cancel.connect("clicked(bool)", self.onCancel)
        form.addRow(self.cancel)
        self.log = qt.QPlainTextEdit()
        self.log.readOnly = True
        form.addRow(self.log)

    def onSegmentation(self, node):
        found = nodes.tissues_of(node) if node is not None else []
        self.colors = [tissue.color for tissue in found]
        self.tissues.setRowCount(len(found))
        for row, tissue in enumerate(found):
            values = [tissue.name, "yes" if tissue.rigid else "no", f"{tissue.young_modulus:g}", f"{tissue.poisson_ratio:g}",
                      f"{tissue.density:g}"]
            for column, text in enumerate(values):
                self.tissues.setItem(row, column, qt.QTableWidgetItem(text))

    def wanted(self):
        """The plan that the widgets show. Raises ValueError if a number is none."""
        found = []
        for row in range(self.tissues.rowCount):
            name, rigid, modulus, ratio, density = (self.tissues.item(row, column).text() for column in range(5))
            found.append(plan.Tissue(name, rigid.strip().lower() in ("yes", "true", "1"), float(modulus), float(ratio),
                                     float(density), self.colors[row]))
        return plan.Plan(found, plan.relations_of(self.relations.toPlainText()), self.tets.value, self.gap.value)

    def onRun(self):
        try:
            self.plan = self.wanted()
            self.process = self.logic.start_meshing(self.command.text, self.selector.currentNode(), self.plan)
        except (OSError, ValueError) as error:
            slicer.util.errorDisplay(str(error))
            return
        self.after = self.onMeshed
        self.run.enabled = False
        self.timer.start()

    def onMeshed(self):
        self.logic.finish_scene(self.plan, self.additions.currentPath)
        self.process = self.logic.start_run(self.command.text)
        self.after = self.onDone
        self.timer.start()

    def onDone(self):
        found = self.logic.show(self.plan)
        for warning in found.warnings:
            self.log.appendPlainText(f"WARNING {warning}")
        for name, value in results.outcome_rows(found):
            self.log.appendPlainText(f"{name}: {value}")
        self.log.appendPlainText(f"page: {self.logic.folder / 'results' / 'report.html'}")
        self.run.enabled = True

    def onTimer(self):
        for line in self.process.lines():
            self.log.appendPlainText(line)
        if not self.process.done:
            return
        self.timer.stop()
        if self.process.code != 0:
            self.run.enabled = True
            slicer.util.errorDisplay("palpate failed; the log says why")
            return
        try:
            self.after()
        except (OSError, ValueError) as error:
            self.run.enabled = True
            slicer.util.errorDisplay(str(error))

    def onCancel(self):
        self.timer.stop()
        if self.process is not None:
            self.process.cancel()
        self.run.enabled = True
