def make_cranium(source, folder, write_mesh): pass
def make_headsq(source, folder, write_mesh): pass
