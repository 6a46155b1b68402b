#include "tests/sim/dynamics/scenes.h"

#include <cmath>

namespace knap::test {

TriangleMesh MakeBar(double a, double b, double c, int nx, int nz) {
  TriangleMesh mesh;
  // Two sheets, y = 0 and y = −b, joined along their rims.
  for (const double y : {0.0, -b}) {
    for (int k = 0; k <= nz; ++k) {
      for (int i = 0; i <= nx; ++i) mesh.vertices.emplace_back(-a + 2.0 * a * i / nx, y, c * k / nz);
    }
  }
  const int sheet = (nx + 1) * (nz + 1);
  const auto front = [&](int i, int k) { return k * (nx + 1) + i; };
  const auto quad = [&](int p, int q, int r, int s) {
    mesh.triangles.emplace_back(p, q, r);
    mesh.triangles.emplace_back(p, r, s);
  };
  for (int k = 0; k < nz; ++k) {
    for (int i = 0; i < nx; ++i) {
      quad(front(i, k), front(i, k + 1), front(i + 1, k + 1), front(i + 1, k));
      quad(sheet + front(i, k), sheet + front(i + 1, k), sheet + front(i + 1, k + 1), sheet + front(i, k + 1));
    }
  }
  for (int i = 0; i < nx; ++i) {
    quad(front(i, 0), front(i + 1, 0), sheet + front(i + 1, 0), sheet + front(i, 0));
    quad(front(i, nz), sheet + front(i, nz), sheet + front(i + 1, nz), front(i + 1, nz));
  }
  for (int k = 0; k < nz; ++k) {
    quad(front(0, k), sheet + front(0, k), sheet + front(0, k + 1), front(0, k + 1));
    quad(front(nx, k), front(nx, k + 1), sheet + front(nx, k + 1), sheet + front(nx, k));
  }
  return mesh;
}

double FindRestingHeight(const BallScene& scene, const ContactMaterial& material, double g) {
  // N(h) = E/(2r²) W h with W = π (r² − h²)²/2 balances the weight.
  const double r = scene.radius;
  double low = 0.9 * r;
  double high = r;
  for (int i = 0; i < 200; ++i) {
    const double h = 0.5 * (low + high);
    const double N = material.stiffness / (2.0 * r * r) * std::acos(-1.0) / 2.0 * std::pow(r * r - h * h, 2) * h;
    (N > scene.mass * g ? low : high) = h;
  }
  return 0.5 * (low + high);
}

}  // namespace knap::test
