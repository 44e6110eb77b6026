"""Makes stretches.png: the stress of each law over stretch and shear, against closed forms.

    ./dev python docs/pictures/stretches.py

The closed forms are written from the papers that docs/materials.md names. Palpate's stress is that of one tet.
"""

import pathlib

import numpy as np

import palpate

YOUNG, POISSON, STIFFNESS, EXPONENT = 20.0, 0.45, 2.0, 0.2
SHEAR, FIRST = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
TET = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
FIBRES = palpate.Fibres(direction=(0, 1, 0), stiffness=STIFFNESS, exponent=EXPONENT)
LAWS = {
    "corotational": {},
    "stable-neo-hookean": {"model": "stable-neo-hookean"},
    "mooney-rivlin, fraction 0.5": {"model": "mooney-rivlin", "mooney_fraction": 0.5},
    "stable-neo-hookean with fibres": {"model": "stable-neo-hookean", "fibres": FIBRES},
}


def corotational():
    """Deformation (diagonal, shear) and nominal stress of each test: Hooke's law of F - R along the axes."""
    both, bulk = YOUNG / (1 - POISSON), YOUNG / (1 - 2 * POISSON)
    return {
        "uniaxial": lambda s: ((1 - POISSON * (s - 1), s, 1 - POISSON * (s - 1)), YOUNG * (s - 1)),
        "equibiaxial": lambda s: ((s, s, 1 - 2 * both / YOUNG * POISSON * (s - 1)), both * (s - 1)),
        "volumetric": lambda s: ((s, s, s), bulk * (s - 1)),
        "shear": lambda k: ((1, 1, 1), 2 * SHEAR * k * (1 - 1 / np.hypot(2, k)) + FIRST * k * (1 - 2 / np.hypot(2, k))),
    }


def hyperelastic(fraction=0.0, stiffness=0.0):
    """The same for Smith, de Goes & Kim's energy with the second invariant and fibres along y."""
    second, mu = fraction * SHEAR, 4 / 3 * (1 - fraction) * SHEAR
    lam = FIRST + 5 / 8 * mu
    alpha = 1 + (3 / 4 * mu + 2 * second) / lam

    def along_y(x, y, z):
        first = x * x + y * y + z * z
        return (mu * y * (1 - 1 / (first + 1)) + second * y * (first - y * y) + lam * (x * y * z - alpha) * x * z
                + 2 * fibre(y) * y)

    def fibre(y):
        e = max(y * y - 1, 0)
        return stiffness * e * np.exp(EXPONENT * e * e)

    def uniaxial(s):  # no stress across: a quadratic equation in the square of the side
        a, b = mu + second * s**2 - lam * alpha * s, second + lam * s**2
        half = (2 * a + b * (s**2 + 1)) / (4 * b)
        side = np.sqrt(-half + np.sqrt(half**2 - (a * (s**2 + 1) - mu) / (2 * b)))
        return (side, s, side), along_y(side, s, side)

    def equibiaxial(s):  # no stress across: a cubic equation in the thickness
        a, d = mu + 2 * second * s**2 + lam * s**4, lam * alpha * s**2
        roots = np.roots([a, -d, a * (2 * s**2 + 1) - mu, -d * (2 * s**2 + 1)])
        thickness = roots[np.abs(roots.imag).argmin()].real
        return (s, s, thickness), along_y(s, s, thickness)

    def shear(k):
        return (1, 1, 1), k * (mu * (1 - 1 / (k * k + 4)) + second + 2 * fibre(np.hypot(1, k)))

    return {"uniaxial": uniaxial, "equibiaxial": equibiaxial, "volumetric": lambda s: ((s, s, s), along_y(s, s, s)), "shear": shear}


def closed_forms():
    """For each law the four tests."""
    return dict(zip(LAWS, (corotational(), hyperelastic(), hyperelastic(fraction=0.5), hyperelastic(stiffness=STIFFNESS))))


def computed(law, test, diagonal, amount):
    """Palpate's nominal stress P = J s F^-T of a tet that is deformed by F (s: Cauchy's): along y, or xy in shear."""
    f = np.diag(np.asarray(diagonal, float))
    if test == "shear":
        f[0, 1] = amount
    model = palpate.Model()
    model.add_body(TET, [[0, 1, 2, 3]], material=palpate.Material(young_modulus=YOUNG, poisson_ratio=POISSON, **LAWS[law]))
    simulation = palpate.Simulation(model)
    simulation.set_positions(TET @ f.T)
    nominal = np.linalg.det(f) * simulation.tissue().stress[0].reshape(3, 3) @ np.linalg.inv(f).T
    return nominal[0 if test == "shear" else 1, 1]


def main():
    """A chart for each test; in kPa."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(8.4, 6.6), layout="constrained")
    for axis, test in zip(axes.flat, ("uniaxial", "equibiaxial", "shear", "volumetric")):
        ends = {"shear": (0, 1), "volumetric": (0.8, 1.2)}.get(test, (0.5, 1.5))
        for (law, tests), color in zip(closed_forms().items(), ("#009e73", "#0072b2", "#d55e00", "#cc79a7")):
            fine, coarse = np.linspace(*ends, 200), np.linspace(*ends, 11)
            axis.plot(fine, [tests[test](s)[1] for s in fine], color=color, linewidth=1.2)
            dots = [computed(law, test, tests[test](s)[0], s) for s in coarse]
            axis.plot(coarse, dots, "o", color=color, markersize=4, label=law)
        axis.set(title=test, xlabel="shear" if test == "shear" else "stretch", ylabel="nominal stress, kPa")
        axis.grid(alpha=0.3)
    axes[0, 0].legend(fontsize=8)
    figure.savefig(pathlib.Path(__file__).parent / "stretches.png", dpi=100)


if __name__ == "__main__":
    main()
