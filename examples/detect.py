"""From meshes to contacts: two balls that overlap."""

import numpy as np

import palpate

points, tets = palpate.ball(radius=0.05, resolution=6)  # or palpate.read_mesh("liver.vtu")
both = np.concatenate([points, points + [0.0, 0.02, 0.08]])
contacts = palpate.detect(both, np.concatenate([tets, tets + len(points)]))
print(f"{len(contacts)} contacts, the deepest {contacts.depth.max() * 1000:.2f} mm")
deepest = contacts.depth.argmax()
print(f"point {contacts.point[deepest]} is in tet {contacts.tet[deepest]} of body {contacts.body[deepest]},",
      f"out: {contacts.direction[deepest].round(2)}")
