"""Makes the pictures of the tutorial out of the examples.

    ./dev python docs/tutorial/pictures.py
"""

import pathlib
import runpy
import sys

import numpy as np
import pandas
import pyvista

import palpate

HERE = pathlib.Path(__file__).parent
EXAMPLES = HERE.parent.parent / "examples"


def example(name, *arguments):
    """The variables of an example after it ran."""
    sys.argv = [name, *arguments]
    return runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")


def plotter():
    """A picture of 800 x 500 pixels."""
    made = pyvista.Plotter(off_screen=True, window_size=(800, 500))
    made.set_background("white")
    return made


def show_contacts(made, positions, contacts):
    """Points in contact in red, and the exit of each: direction times depth."""
    places = positions[contacts.point]
    made.add_points(places, color="red", point_size=6, render_points_as_spheres=True)
    ends = places + contacts.depth[:, None] * contacts.direction
    made.add_lines(np.stack([places, ends], axis=1).reshape(-1, 3), color="black", width=2)


def save(made, name, camera):
    """Takes the picture."""
    made.camera_position = camera
    made.screenshot(HERE / f"{name}.png")


def main():
    """All four."""
    shown = example("detect")
    made = plotter()
    for shift, color in [(0.0, "tan"), (np.array([0.0, 0.02, 0.08]), "lightblue")]:
        made.add_mesh(palpate.to_pyvista(shown["points"] + shift, shown["tets"]), color=color, opacity=0.35)
    show_contacts(made, shown["both"], shown["contacts"])
    save(made, "detect", [(0.42, -0.07, 0.11), (0, 0.01, 0.04), (0, 0, 1)])

    shown = example("world")
    made = plotter()
    made.add_mesh(shown["world"].to_pyvista(shown["positions"]), scalars="body", preference="cell", cmap="Pastel1", show_edges=True, edge_opacity=0.3,
                  show_scalar_bar=False)
    save(made, "world", [(0.25, -0.2, 0.25), (0, 0, 0.03), (0, 0, 1)])

    simulation = example("simulate")["simulation"]
    grid = simulation.to_pyvista()
    grid.point_data["moved, mm"] = 1000 * np.linalg.norm(simulation.positions - simulation.bodies.points_rest, axis=1)
    block = grid.extract_cells(np.arange(simulation.bodies["block"].tets.stop))
    plate = grid.extract_cells(np.arange(simulation.bodies["plate"].tets.start, simulation.bodies["plate"].tets.stop))
    made = plotter()
    made.add_mesh(block, scalars="moved, mm", cmap="viridis", show_edges=True,
                  scalar_bar_args={"color": "black", "vertical": True, "position_x": 0.87, "height": 0.6, "position_y": 0.2})
    made.add_mesh(plate, color="lightgray", opacity=0.5, show_edges=True)
    save(made, "simulate", [(0.08, -0.16, 0.06), (0, 0, 0), (0, 0, 1)])

    draw_study(pandas.DataFrame(example("study")["rows"]))


def draw_study(table):
    """The tip and the force of the rod over the plan, a line for each stiffness."""
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
    for stiffness, rows in table.groupby("young_modulus"):
        for axis, column in zip(axes, ["tip_mm", "rod_newton"]):
            axis.plot(1000 * rows["down"], rows[column], "o-", label=f"E = {stiffness / 1000:.0f} kPa")
    axes[0].set(xlabel="bone down, mm", ylabel="tip of the tissue, mm")
    axes[1].set(xlabel="bone down, mm", ylabel="force on the rod, N")
    axes[0].legend()
    figure.savefig(HERE / "study.png", dpi=100)


if __name__ == "__main__":
    main()
