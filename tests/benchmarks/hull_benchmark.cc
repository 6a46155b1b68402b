// What a convex mesh's faces cost: wrench and derivatives of a mesh of 1,600 facets against hulls of 8 to 512 faces.
// Prints; gates nothing.
#include <benchmark/benchmark.h>

#include <memory>

#include "sim/contact/contact_side.h"
#include "sim/contact/convex_field.h"
#include "tests/sim/contact/convex_meshes.h"
#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace {

using Eigen::Vector3d;

void Measure(benchmark::State& state, const ContactGeometry& touching, const Pose& X_SB) {
  ContactPair pair;
  pair.bodies = {0, 1};
  pair.shapes = {touching, *MakeConvexMesh(test::MakeRoundHull(0.02, static_cast<int>(state.range(0))))};
  pair.material.stiffness = 1e8;
  const ContactSide side = MakeSides({pair})[0];
  NearFacets near(side);
  SidePatches at;
  for (auto _ : state) {
    CalcPatches(side, &near, X_SB, &at);
    CalcPatchJacobians(side, &at);
  }
  state.counters["faces"] = side.num_cells();
  state.counters["facets"] = static_cast<double>(side.facets->facets().size());
  state.counters["regions"] = static_cast<double>(at.facets.regions.size());
}

void MeshInHull(benchmark::State& state) {
  const TriangleMesh bar = test::MakeBar(0.06, 0.012, 0.06, 20, 20);
  Measure(
      state, MeshGeometry{std::make_shared<ContactMesh>(bar)},
      {Eigen::AngleAxisd(0.3, Vector3d(1.0, 0.5, 0.2).normalized()).toRotationMatrix(), Vector3d(0.001, 0.019, -0.03)});
}
BENCHMARK(MeshInHull)->DenseRange(0, 3)->Unit(benchmark::kMicrosecond);

void BoxInHull(benchmark::State& state) {
  Measure(state, BoxGeometry{Vector3d::Constant(0.02), Vector3d::Zero()},
          {Eigen::AngleAxisd(0.3, Vector3d(1.0, 0.5, 0.2).normalized()).toRotationMatrix(), Vector3d(0.0, 0.0, 0.038)});
}
BENCHMARK(BoxInHull)->DenseRange(0, 3)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace knap
