#include "anatomy/round_points.hpp"

#include <cmath>

namespace palpate::anatomy {

void round_points(TetMesh& mesh) {
  constexpr double unit = 0x1p-20;
  const auto rounded = [](double x) { return unit * std::nearbyint(x / unit); };
  for (Vec3& p : mesh.points) p = {rounded(p.x), rounded(p.y), rounded(p.z)};
}

}  // namespace palpate::anatomy
