"""A stand-in for the parts of 3D Slicer that slicer/PalpatePlan uses, after its documentation (slicer.readthedocs.io, script
repository; headers vtkMRMLSequenceNode.h, vtkMRMLSegmentationNode.h, vtkSlicerSegmentationsModuleLogic.h). It has no other methods, and refuses types that Slicer refuses.
"""

import sys
import types

import numpy as np
import vtk


def want(value, kind, what):
    if not isinstance(value, kind):
        raise TypeError(f"{what}: a {type(value).__name__}, where Slicer takes {kind}")
    return value


class Node:
    def __init__(self, name=""):
        self._name = want(name, str, "name")

    def GetName(self):
        return self._name


class Segment:
    def __init__(self, name, color, mask):
        self._name, self._color, self.mask = name, color, mask

    def GetName(self):
        return self._name

    def GetColor(self):
        return self._color


class Segmentation:
    EXTENT_UNION_OF_EFFECTIVE_SEGMENTS, EXTENT_REFERENCE_GEOMETRY = 0, 4

    def __init__(self, segments):
        self._segments = segments

    def GetNumberOfSegments(self):
        return len(self._segments)

    def GetNthSegmentID(self, number):
        return f"Segment_{number}"

    def GetSegment(self, identifier):
        return self._segments[int(identifier.rpartition("_")[2])]


class SegmentationNode(Node):
    """segments: (name, colour, mask (k, j, i)) each. Voxels of 1 mm, the first at the origin of RAS."""

    def __init__(self, segments, transform=None):
        super().__init__("Segmentation")
        self._segmentation = Segmentation([Segment(*segment) for segment in segments])
        self._transform = transform

    def GetSegmentation(self):
        return self._segmentation

    def GetParentTransformNode(self):
        return self._transform


class LabelMapVolumeNode(Node):
    labels = None


class DisplayNode(Node):
    color = (0.5, 0.5, 0.5)

    def SetColor(self, red, green, blue):
        self.color = (want(red, float, "red"), want(green, float, "green"), want(blue, float, "blue"))


class ModelNode(Node):
    _poly_data = None
    _display = None

    def SetAndObservePolyData(self, poly_data):
        self._poly_data = want(poly_data, vtk.vtkPolyData, "poly data")

    def GetPolyData(self):
        return self._poly_data

    def CreateDefaultDisplayNodes(self):
        self._display = self._display or DisplayNode()

    def GetDisplayNode(self):
        return self._display

    def copied(self):
        copy = ModelNode(self._name)
        copy._poly_data = vtk.vtkPolyData()
        copy._poly_data.DeepCopy(self._poly_data)
        return copy


class SequenceNode(Node):
    def __init__(self, name=""):
        super().__init__(name)
        self._nodes = {}
        self.index = ["", ""]

    def SetIndexName(self, name):
        self.index[0] = want(name, str, "index name")

    def SetIndexUnit(self, unit):
        self.index[1] = want(unit, str, "index unit")

    def SetDataNodeAtValue(self, node, value):
        """Stores a deep copy; replaces one with the same index value."""
        self._nodes[want(value, str, "index value")] = want(node, ModelNode, "node").copied()

    def GetNumberOfDataNodes(self):
        return len(self._nodes)

    def GetNthDataNode(self, number):
        return list(self._nodes.values())[number]

    def GetNthIndexValue(self, number):
        return list(self._nodes)[number]


class SequenceBrowserNode(Node):
    def __init__(self, name=""):
        super().__init__(name)
        self.pairs = []
        self.selected = -1

    def SetSelectedItemNumber(self, number):
        self.selected = want(number, int, "item")


CLASSES = {"vtkMRMLLabelMapVolumeNode": LabelMapVolumeNode, "vtkMRMLModelNode": ModelNode,
           "vtkMRMLSequenceNode": SequenceNode, "vtkMRMLSequenceBrowserNode": SequenceBrowserNode}


class Scene:
    def __init__(self):
        self.nodes = []

    def AddNewNodeByClass(self, name, node_name=""):
        self.nodes.append(CLASSES[want(name, str, "class")](node_name))
        return self.nodes[-1]

    def RemoveNode(self, node):
        self.nodes.remove(node)


class SegmentationsLogic:
    def ExportAllSegmentsToLabelmapNode(self, segmentation, volume, mode=Segmentation.EXTENT_UNION_OF_EFFECTIVE_SEGMENTS):
        found = want(segmentation, SegmentationNode, "segmentation").GetSegmentation()
        segments = [found.GetSegment(found.GetNthSegmentID(i)) for i in range(found.GetNumberOfSegments())]
        if not segments or mode != Segmentation.EXTENT_REFERENCE_GEOMETRY:
            return False
        want(volume, LabelMapVolumeNode, "volume").labels = np.zeros(segments[0].mask.shape, np.int16)
        for number, segment in enumerate(segments, 1):
            volume.labels[segment.mask] = number
        return True


class SequencesLogic:
    def AddSynchronizedNode(self, sequence, proxy, browser):
        want(browser, SequenceBrowserNode, "browser").pairs.append(
            (want(sequence, SequenceNode, "sequence"), want(proxy, ModelNode, "proxy")))
        return sequence

    def UpdateProxyNodesFromSequences(self, browser):
        for sequence, proxy in browser.pairs:
            proxy.SetAndObservePolyData(sequence.GetNthDataNode(browser.selected).copied().GetPolyData())


def save_node(node, filename, properties={}):  # like slicer.util.saveNode
    """NRRD of a label map, as Slicer writes it: in LPS, with x and y opposite to RAS."""
    labels = want(node, LabelMapVolumeNode, "node").labels
    k, j, i = labels.shape
    head = (f"NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {i} {j} {k}\n"
            "space directions: (-1,0,0) (0,-1,0) (0,0,1)\nkinds: domain domain domain\nendian: little\nencoding: raw\n"
            "space origin: (0,0,0)\n\n")
    with open(want(filename, str, "filename"), "wb") as stream:
        stream.write(head.encode() + labels.astype("<i2").tobytes())
    return True


def module(name, **members):
    made = types.ModuleType(name)
    made.__dict__.update(members)
    return made


def install(environment):
    """Installs modules slicer, qt and ctk, as in Slicer's Python; returns slicer."""
    active = []
    sequences = types.SimpleNamespace(logic=SequencesLogic, setToolBarActiveBrowserNode=active.append, active=active)

    class Base:
        def __init__(self, parent=None):
            self.parent = parent

    slicer = module("slicer", mrmlScene=Scene(), vtkSegmentation=Segmentation,
                    modules=types.SimpleNamespace(segmentations=types.SimpleNamespace(logic=SegmentationsLogic), sequences=sequences),
                    util=types.SimpleNamespace(saveNode=save_node, startupEnvironment=lambda: environment))
    slicer.ScriptedLoadableModule = module("slicer.ScriptedLoadableModule", ScriptedLoadableModule=Base,
                                           ScriptedLoadableModuleLogic=Base, ScriptedLoadableModuleWidget=Base)
    sys.modules.update({"slicer": slicer, "slicer.ScriptedLoadableModule": slicer.ScriptedLoadableModule,
                        "qt": module("qt"), "ctk": module("ctk")})
    return slicer
