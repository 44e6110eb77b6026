"""A CT on a lattice of cubes, and what both scenes ask of it. Lengths in mm; x to the left, y to the back, z up."""

import io
import plistlib
import tarfile

import numpy as np
import SimpleITK as sitk


def read_inv3(path):
    """The image of an InVesalius project: Hounsfield units. Rows of the matrix run from back to front."""
    with tarfile.open(path) as archive:
        files = {member.name.rsplit("/", 1)[-1]: member for member in archive.getmembers()}
        main = plistlib.loads(archive.extractfile(files["main.plist"]).read())
        matrix = main["matrix"]
        values = np.frombuffer(archive.extractfile(files[matrix["filename"]]).read(), dtype="<i2")
    image = sitk.GetImageFromArray(values.reshape(matrix["shape"])[:, ::-1, :])
    image.SetSpacing(main["spacing"])
    return image


def read_slices(files, size, spacing):
    """Raw slices of uint16, one file each, from the lowest."""
    values = np.stack([np.fromfile(file, dtype="<u2").reshape(size[::-1]) for file in files])
    image = sitk.GetImageFromArray(values.astype(np.int16))
    image.SetSpacing(spacing)
    return image


def cubes(image, lower, upper, edge):
    """The part between two corners (mm), as floats on cubes."""
    size = [int(round((b - a) / edge)) for a, b in zip(lower, upper)]
    return sitk.Resample(sitk.Cast(image, sitk.sitkFloat32), size, sitk.Transform(), sitk.sitkLinear, list(lower), [edge] * 3,
                         [1, 0, 0, 0, 1, 0, 0, 0, 1], -1000.0)


def mask(like, array):
    """A 0/1 image on the lattice of another."""
    image = sitk.GetImageFromArray(np.ascontiguousarray(array).astype(np.uint8))
    image.CopyInformation(like)
    return image


def array(image):
    return sitk.GetArrayFromImage(image)


def distance_to(image):
    """Distance (mm) of each cube from the nearest one in the mask; 0 in it."""
    if not array(image).any():
        return np.full(array(image).shape, np.inf)
    return np.maximum(array(sitk.SignedMaurerDistanceMap(image, squaredDistance=False, useImageSpacing=True)), 0.0)


def grown(like, inside, reach):
    return distance_to(mask(like, inside)) <= reach


def shrunk(like, inside, reach):
    return ~grown(like, ~inside, reach)


def opened(like, inside, reach):
    """Without what is thinner than twice the reach."""
    return grown(like, shrunk(like, inside, reach), reach) & inside


def closed(like, inside, reach):
    return shrunk(like, grown(like, inside, reach), reach) | inside


def parts(like, inside):
    """The connected parts, largest first, each a mask."""
    labels = array(sitk.RelabelComponent(sitk.ConnectedComponent(mask(like, inside))))
    return labels


def largest(like, inside):
    return parts(like, inside) == 1


def flooded(like, inside, seed):
    """The connected part of the mask that a cube (k, j, i) is in."""
    labels = array(sitk.ConnectedComponent(mask(like, inside)))
    assert labels[seed] > 0, f"the seed {seed} is not in the mask"
    return labels == labels[seed]


def places(like):
    """x, y and z of each cube."""
    origin, edge = like.GetOrigin(), like.GetSpacing()
    axes = [origin[a] + edge[a] * np.arange(like.GetSize()[a]) for a in range(3)]
    z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
    return x, y, z


def write_labels(path, like, organs, origin):
    """A label map with names, as 3D Slicer writes it; a cube in several organs belongs to the first. `origin` becomes (0, 0, 0)."""
    labels = np.zeros(like.GetSize()[::-1], np.uint8)
    for number, inside in reversed(list(enumerate(organs.values(), 1))):
        labels[inside] = number
    image = sitk.GetImageFromArray(labels)
    image.SetSpacing(like.GetSpacing())
    image.SetOrigin([a - b for a, b in zip(like.GetOrigin(), origin)])
    for number, name in enumerate(organs, 1):
        image.SetMetaData(f"Segment{number - 1}_LabelValue", str(number))
        image.SetMetaData(f"Segment{number - 1}_Name", name)
    sitk.WriteImage(image, str(path), True)
    return labels
