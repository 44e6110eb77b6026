"""Names that settings take, for type checkers; a test compares them with the schema of scenes."""

from typing import Literal

Structure = Literal["uniform", "compact", "hash", "cuckoo", "brute"]
Order = Literal["linear", "z"]
Sort = Literal["radix", "counting", "comparison", "repair", "adaptive"]
CellSizeRule = Literal["auto", "mean-edge", "max-edge"]
