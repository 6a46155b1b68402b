// The deepest place of bodies in depth fields of every kind: its depth against the largest of many places of the
// surface, what moves it against differences, for random bodies and places.
#include "sim/contact/deepest_place.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "sim/contact/convex_field.h"
#include "sim/math/so3.h"
#include "tests/sim/contact/convex_meshes.h"
#include "tests/sim/contact/field_depth.h"
#include "tests/sim/contact/random_places.h"

namespace knap {
namespace {

using Eigen::Vector3d;

using Random = test::RandomPlaces;

ContactGeometry MakeShape(const std::string& kind, Random* random) {
  const Vector3d center = random->Vec(0.002);
  if (kind == "sphere") return SphereGeometry{random->U(0.004, 0.01), center};
  if (kind == "capsule")
    return CapsuleGeometry{random->U(0.003, 0.006), random->U(0.004, 0.01), center, random->Vec(1.0).normalized()};
  if (kind == "cylinder")
    return CylinderGeometry{random->U(0.005, 0.01), random->U(0.006, 0.012), center, random->Vec(1.0).normalized()};
  if (kind == "disc")
    return CylinderGeometry{random->U(0.008, 0.012), random->U(0.001, 0.002), center, random->Vec(1.0).normalized()};
  if (kind == "box") {
    return BoxGeometry{{random->U(0.004, 0.01), random->U(0.004, 0.01), random->U(0.002, 0.01)},
                       center,
                       ExpSo3(random->Vec(2.0)).toRotationMatrix()};
  }
  if (kind == "hull") return *MakeConvexMesh(test::MakeRoundHull(random->U(0.006, 0.01), 1));
  if (kind == "pyramid") return *MakeConvexMesh(test::MakePyramid());
  if (kind == "designed") {
    TriangleMesh mesh = test::MakeRoundHull(0.008, 1);
    for (Vector3d& x : mesh.vertices) x *= random->U(0.6, 1.2);
    return MeshGeometry{std::make_shared<ContactMesh>(mesh)};
  }
  return HalfSpaceGeometry{};
}

// Calls visit for places all over B's surface, or of a round B all over its axis, no farther apart than the return
// value [m].
double SampleBody(const ContactSide& side, const Pose& X_SB, const std::function<void(const Vector3d&)>& visit) {
  constexpr int kMany = 60;
  if (side.axis) {
    const RoundAxis axis = side.axis->Move(X_SB);
    for (int i = 0; i <= kMany; ++i) visit(axis.center + (2.0 * i / kMany - 1.0) * axis.half_length * axis.direction);
    return 2.0 * axis.half_length / kMany;
  }
  if (side.cylinder) {
    const SolidCylinder c = side.cylinder->Move(X_SB);
    const Vector3d u = c.direction.unitOrthogonal(), w = c.direction.cross(u);
    for (int i = 0; i < 400; ++i) {
      const Vector3d out = c.radius * (std::cos(i * M_PI / 200.0) * u + std::sin(i * M_PI / 200.0) * w);
      for (const double end : {-1.0, 1.0}) visit(c.center + out + end * c.half_length * c.direction);
    }
    return 0.016 * c.radius;
  }
  double apart = 0.0;
  for (const Facet& facet : side.facets->facets()) {
    for (int second = 1; second + 1 < facet.size; ++second) {
      const Vector3d a = X_SB * facet.Place(0), b = X_SB * facet.Place(second), c = X_SB * facet.Place(second + 1);
      for (int i = 0; i <= kMany; ++i) {
        for (int j = 0; i + j <= kMany; ++j) visit(a + (b - a) * i / kMany + (c - a) * j / kMany);
      }
      apart = std::max({apart, (b - a).norm() / kMany, (c - a).norm() / kMany});
    }
  }
  return apart;
}

Pose Perturb(const Pose& X, int k, double size) {
  if (k >= 3) return {X.R, X.p + size * Vector3d::Unit(k - 3)};
  const Eigen::Matrix3d turn = ExpSo3(size * Vector3d::Unit(k)).toRotationMatrix();
  return {turn * X.R, turn * X.p};
}

struct Kinds {
  std::string first, second;
};

class DeepestPlaces : public testing::TestWithParam<Kinds> {};

TEST_P(DeepestPlaces, AreTheDeepestAndMoveAsDifferencesSay) {
  int touching = 0, kinks = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    Random random(seed);
    ContactPair pair;
    pair.bodies = {0, 1};
    pair.shapes = {MakeShape(GetParam().first, &random), MakeShape(GetParam().second, &random)};
    pair.material.stiffness = 1e8;
    for (const ContactSide& side : MakeSides({pair})) {
      NearFacets near(side);
      SidePatches scratch;
      const Pose X_SB = random.MakePose(2.0, 0.008);
      const auto find = [&](const Pose& X) { return FindDeepestPlace(side, X, &near, &scratch); };
      const DeepestPlace place = find(X_SB);

      // A round B's axis is in the field widened by B's radius.
      DepthField field = side.field;
      double shift = 0.0;
      if (side.axis) {
        if (auto* round = std::get_if<RoundField>(&field)) {
          round->radius += side.axis->radius;
        } else {
          shift = side.axis->radius;
        }
      }
      int cell = 0;
      double deepest = 0.0;
      const double apart = SampleBody(side, X_SB, [&](const Vector3d& x) {
        deepest = std::max(deepest, test::CalcFieldDepth(field, x, &cell) + shift);
      });
      EXPECT_GE(place.depth, deepest - 1e-14) << seed;
      EXPECT_LE(place.depth, deepest + apart + 1e-12) << seed << " of " << side.body;
      if (place.depth < 1e-5) continue;
      EXPECT_NEAR(test::CalcFieldDepth(field, place.p_S, &cell) + shift, place.depth, 1e-14) << seed;
      ++touching;
      const double h = 1e-7;
      bool kink = false;
      for (int k = 0; k < 6; ++k) {
        const double ahead = (find(Perturb(X_SB, k, h)).depth - place.depth) / h;
        const double behind = (place.depth - find(Perturb(X_SB, k, -h)).depth) / h;
        const double moment = k < 3 ? place.p_S.cross(place.g_S)(k) : place.g_S(k - 3);
        const double scale = k < 3 ? 0.01 : 1.0;
        if (std::abs(ahead - behind) > 1e-3 * scale) {
          kink = true;
          continue;
        }
        EXPECT_NEAR(moment, 0.5 * (ahead + behind), 1e-5 * scale)
            << seed << " of " << side.body << " " << k << " facet " << place.facet;
      }
      kinks += kink ? 1 : 0;
    }
  }
  EXPECT_GE(touching, 15);
  EXPECT_LE(kinks, touching / 20);
}

std::vector<Kinds> ListKinds() {
  std::vector<Kinds> kinds;
  for (const char* field : {"sphere", "capsule", "cylinder", "disc", "box", "hull", "pyramid", "half-space"}) {
    kinds.push_back({"designed", field});
    kinds.push_back({"box", field});
  }
  for (const char* touching : {"sphere", "capsule", "cylinder", "hull"}) kinds.push_back({touching, "half-space"});
  kinds.insert(kinds.end(), {{"sphere", "capsule"}, {"capsule", "capsule"}, {"sphere", "sphere"}, {"hull", "disc"}});
  return kinds;
}

INSTANTIATE_TEST_SUITE_P(All, DeepestPlaces, testing::ValuesIn(ListKinds()), [](const auto& the_case) {
  std::string name = the_case.param.first + "_" + the_case.param.second;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace knap
