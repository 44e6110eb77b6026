"""Segmentations out of Slicer, models and sequences into it. `slicer` and `vtk` are handed in: their modules in Slicer."""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Mapping
from typing import Any

from .plan import Tissue
from .results import Results


def tissues_of(segmentation_node: Any) -> list[Tissue]:
    """The segments of a segmentation, in their order, which is the order of their labels."""
    segmentation = segmentation_node.GetSegmentation()
    tissues = []
    for number in range(segmentation.GetNumberOfSegments()):
        segment = segmentation.GetSegment(segmentation.GetNthSegmentID(number))
        tissues.append(Tissue(segment.GetName(), color=tuple(segment.GetColor())))
    return tissues


def export_label_map(slicer: Any, segmentation_node: Any, file: pathlib.Path) -> None:
    """Writes all segments as a label map (.nrrd): segment n, from 0, has label n + 1. Of segments that overlap the
    later one counts. Raises ValueError if the node is transformed or Slicer refuses.
    """
    if segmentation_node.GetParentTransformNode() is not None:
        raise ValueError("the segmentation is transformed: harden the transform first")
    volume = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLLabelMapVolumeNode", "palpate labels")
    try:
        if not slicer.modules.segmentations.logic().ExportAllSegmentsToLabelmapNode(
                segmentation_node, volume, slicer.vtkSegmentation.EXTENT_REFERENCE_GEOMETRY):
            raise ValueError("Slicer could not export the segmentation to a label map")
        if not slicer.util.saveNode(volume, str(file)):
            raise ValueError(f"Slicer could not write {file}")
    finally:
        slicer.mrmlScene.RemoveNode(volume)


def surfaces_of(vtk: Any, file: pathlib.Path, bodies: int) -> list[Any]:
    """The surface of each body in a frame, with the arrays of its points."""
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(file))
    reader.Update()
    surfaces = []
    for body in range(bodies):
        threshold = vtk.vtkThreshold()
        threshold.SetInputConnection(reader.GetOutputPort())
        threshold.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, "body")
        threshold.SetThresholdFunction(vtk.vtkThreshold.THRESHOLD_BETWEEN)
        threshold.SetLowerThreshold(body)
        threshold.SetUpperThreshold(body)
        surface = vtk.vtkDataSetSurfaceFilter()
        surface.SetInputConnection(threshold.GetOutputPort())
        surface.Update()
        surfaces.append(surface.GetOutput())
    return surfaces


def show_results(slicer: Any, vtk: Any, results: Results, colors: Mapping[str, tuple[float, float, float]],
                 progress: Callable[[int, int], None] = lambda done, all: None) -> Any:
    """A model and a sequence of it for each body, and a browser that plays them together. Returns the browser."""
    scene = slicer.mrmlScene
    logic = slicer.modules.sequences.logic()
    browser = scene.AddNewNodeByClass("vtkMRMLSequenceBrowserNode", "palpate")
    models, sequences = [], []
    for name in results.bodies:
        model = scene.AddNewNodeByClass("vtkMRMLModelNode", name)
        sequence = scene.AddNewNodeByClass("vtkMRMLSequenceNode", f"{name} over time")
        sequence.SetIndexName("time")
        sequence.SetIndexUnit(results.time_unit)
        models.append(model)
        sequences.append(sequence)
    for number, frame in enumerate(results.frames):
        for model, sequence, surface in zip(models, sequences, surfaces_of(vtk, frame.file, len(models))):
            model.SetAndObservePolyData(surface)
            sequence.SetDataNodeAtValue(model, f"{frame.time:g}")  # copies the model as it is now
        progress(number + 1, len(results.frames))
    for name, model, sequence in zip(results.bodies, models, sequences):
        model.CreateDefaultDisplayNodes()
        if name in colors:
            model.GetDisplayNode().SetColor(*colors[name])
        logic.AddSynchronizedNode(sequence, model, browser)
    browser.SetSelectedItemNumber(max(0, len(results.frames) - 1))
    logic.UpdateProxyNodesFromSequences(browser)
    return browser
