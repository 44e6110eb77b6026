"""A simulator of one's own that uses only detection: stiff balls that fall into a bowl of three others.

Each ball is a rigid body with one velocity; the penalty forces are two lines of NumPy. The world gets the positions
of all points in each step and tells who touches whom, how deep, and which way is out.
"""

import numpy as np

import palpate

STEP, STIFFNESS, DAMPING = 0.001, 3000.0, 30.0  # s, N/m for each point in contact, N s/m
points, tets = palpate.ball(radius=0.05, resolution=5)
centers = np.array([[0.06, 0.0, 0.0], [-0.03, 0.052, 0.0], [-0.03, -0.052, 0.0], [0.01, 0.005, 0.12]])
velocities = np.zeros_like(centers)
free = np.array([False, False, False, True])  # the bowl stays where it is
mass = 0.2

world = palpate.World()
for number, is_free in enumerate(free):
    world.add(points + centers[number], tets, name=f"ball {number}", movable=bool(is_free))
body_of_point = world.bodies.body_of_point

for step in range(600):
    world.update([points + center for center in centers])
    contacts = world.contacts
    own = body_of_point[contacts.point]
    force = STIFFNESS * contacts.depth[:, None] * contacts.direction  # on the point, out of the other body
    total = np.zeros_like(centers)
    np.add.at(total, own, force)
    np.add.at(total, contacts.body, -force)
    touching = np.bincount(own, minlength=len(centers)) + np.bincount(contacts.body, minlength=len(centers)) > 0
    total[touching] -= DAMPING * velocities[touching]
    velocities[free] += STEP * (total[free] / mass + [0.0, 0.0, -9.81])
    centers[free] += STEP * velocities[free]
    if step % 150 == 149:
        print(f"t = {step + 1:3d} ms: height {centers[3, 2] * 1000:5.1f} mm, {len(contacts):3d} contacts")

positions = np.concatenate([points + center for center in centers])  # world.to_pyvista(positions) shows them, with pyvista
print(f"at rest on {len(np.unique(contacts.body[own == 3]))} balls")
