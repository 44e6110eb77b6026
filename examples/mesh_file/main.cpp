// Reads a mesh file and tells what is in it.
#include <cstdio>
#include <exception>
#include <utility>

#include <palpate/io/mesh_reader.hpp>
#include <palpate/palpate.hpp>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    palpate::io::MeshFile file = palpate::io::read_mesh(argv[1]);
    palpate::Bodies bodies;
    bodies.add(argv[1], std::move(file.mesh));
    const palpate::MeshStatistics found = palpate::mesh_statistics(bodies, bodies.points_rest());
    std::printf("%s: %d points, %d tets, volume %.3f\n", file.format.c_str(), found.points, found.tets,
                found.volume);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
