"""Names that settings take, for type checkers; a test compares them with the schema of scenes."""

from typing import Literal

Structure = Literal["uniform", "compact", "hash", "cuckoo", "brute"]
Order = Literal["linear", "z"]
Sort = Literal["radix", "counting", "comparison", "repair", "adaptive"]
CellSizeRule = Literal["auto", "mean-edge", "max-edge"]
MaterialModel = Literal["corotational", "stable-neo-hookean", "mooney-rivlin"]
ElementKind = Literal["linear", "smoothed"]
Tissue = Literal[
    "liver", "kidney", "spleen", "brain", "fat", "muscle", "skin", "sclera", "tendon", "cartilage", "trabecular-bone", "cortical-bone"]
Field = Literal[
    "contact_force", "contact_traction", "contact_pressure", "reaction", "deformation_gradient", "strain", "stress", "von_mises", "pressure",
    "principal_stress", "principal_directions", "energy_density", "plastic_strain", "volume_ratio"]
