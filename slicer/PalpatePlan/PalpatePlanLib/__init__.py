"""What the module PalpatePlan does, apart from its widgets: no file here imports slicer, qt or vtk."""
