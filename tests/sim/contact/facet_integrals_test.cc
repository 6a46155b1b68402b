// Facets in depth fields: against plain sums over a fine lattice, against the energy, and derivatives against
// differences, for random triangles in boxes, half-spaces, convex meshes, spheres, capsules and cylinders.
#include "sim/contact/facet_integrals.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "sim/contact/contact_side.h"
#include "sim/contact/convex_field.h"
#include "sim/math/so3.h"
#include "tests/sim/contact/convex_meshes.h"
#include "tests/sim/contact/designed_meshes.h"
#include "tests/sim/contact/field_depth.h"
#include "tests/sim/contact/patch_differences.h"
#include "tests/sim/contact/random_places.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Random = test::RandomPlaces;

DepthField MakeField(int kind) {
  const Vector3d center(0.001, -0.002, 0.0015);
  if (kind == 0) return PolyhedralField::MakeHalfSpace();
  if (kind == 1) return PolyhedralField::MakeBox({0.010, 0.007, 0.005}, center);
  if (kind == 2) return RoundField{0.008, 0.0, center};
  if (kind == 3) return RoundField{0.005, 0.009, center};
  const Vector3d axis = Vector3d(0.3, -0.5, 0.8).normalized();
  if (kind == 4) return CylinderField{0.006, 0.007, center, axis};
  // Flatter than half its radius: the ends' cells meet.
  if (kind == 5) return CylinderField{0.009, 0.002, center, axis};
  if (kind == 6) return *MakeConvexField(test::MakePyramid());
  return *MakeConvexField(test::MakeRoundHull(0.009, 1));
}

using Triangle = std::array<Vector3d, 3>;

struct Sums {
  std::vector<PatchIntegrals> patches;
  std::vector<PatchJacobian> jacobians;
};

// By cells.
Sums SumFacet(const Triangle& triangle, const DepthField& field) {
  FacetRegions cut;
  CutFacet(0, Facet::Make(triangle), field, &cut);
  const auto cells = static_cast<std::size_t>(CountCells(field));
  Sums out{std::vector<PatchIntegrals>(cells), std::vector<PatchJacobian>(cells, PatchJacobian::Zero())};
  for (const FacetRegion& region : cut.regions) {
    AddRegion(region, &out.patches[static_cast<std::size_t>(region.cell)]);
    AddRegionJacobian(region, cut.walls, &out.jacobians[static_cast<std::size_t>(region.cell)]);
  }
  for (std::size_t c = 0; c < cells; ++c) FinishJacobian(out.patches[c], &out.jacobians[c]);
  return out;
}

std::vector<PatchIntegrals> SumByLattice(const Triangle& corner, const DepthField& field, int n) {
  std::vector<PatchIntegrals> sums(static_cast<std::size_t>(CountCells(field)));
  const Vector3d a = corner[1] - corner[0];
  const Vector3d b = corner[2] - corner[0];
  const Vector3d normal = a.cross(b).normalized();
  const double dA = 0.5 * a.cross(b).norm() / (n * n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      for (int upper = 0; upper < (i + j + 1 < n ? 2 : 1); ++upper) {
        const double third = upper == 0 ? 1.0 / 3.0 : 2.0 / 3.0;
        const Vector3d x = corner[0] + (i + third) / n * a + (j + third) / n * b;
        int cell = 0;
        const double e = std::max(0.0, test::CalcFieldDepth(field, x, &cell));
        PatchIntegrals& sum = sums[static_cast<std::size_t>(cell)];
        sum.F -= e * dA * normal;
        sum.M -= e * dA * x.cross(normal);
        sum.W += e * dA;
        sum.m1 += e * dA * x;
        sum.m2 += e * dA * x * x.transpose();
      }
    }
  }
  return sums;
}

Triangle MakeTriangle(Random* random, double size) {
  Triangle out;
  for (Vector3d& x : out) x = random->Vec(size);
  return out;
}

class FacetIntegralsTest : public testing::TestWithParam<int> {};

TEST_P(FacetIntegralsTest, EqualsALattice) {
  const DepthField field = MakeField(GetParam());
  Random random(7);
  for (int trial = 0; trial < 12; ++trial) {
    const Triangle facet = MakeTriangle(&random, 0.015);
    const std::vector<PatchIntegrals> exact = SumFacet(facet, field).patches;
    const std::vector<PatchIntegrals> sums = SumByLattice(facet, field, GetParam() < 6 ? 400 : 1000);
    PatchIntegrals::Vector whole = PatchIntegrals::Vector::Zero();
    for (const PatchIntegrals& sum : sums) whole = whole.cwiseMax(test::Pack(sum).cwiseAbs());
    if (!(whole(6) > 1e-9)) continue;  // smaller than a few parts of the lattice
    for (std::size_t cell = 0; cell < exact.size(); ++cell) {
      const PatchIntegrals::Vector error = (test::Pack(exact[cell]) - test::Pack(sums[cell])).cwiseAbs();
      // The lattice misses by a share of its parts along the region's edge; they are some 0.05 mm large, smaller where
      // cells are.
      for (const auto& [first, count] : {std::pair{0, 3}, {3, 3}, {6, 1}, {7, 3}, {10, 6}}) {
        EXPECT_LE(error.segment(first, count).maxCoeff(), 1e-3 * whole.segment(first, count).maxCoeff() + 1e-18)
            << "cell " << cell << ", trial " << trial << ", from " << first;
      }
    }
  }
}

TEST_P(FacetIntegralsTest, MovesAsDifferencesSay) {
  const DepthField field = MakeField(GetParam());
  Random random(11);
  int compared = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Triangle facet = MakeTriangle(&random, 0.012);
    const Pose X_SB = random.MakePose(1.0, 0.004);
    const auto calc = [&](const Pose& X) { return SumFacet({X * facet[0], X * facet[1], X * facet[2]}, field); };
    const auto [patches, jacobians] = calc(X_SB);
    for (std::size_t cell = 0; cell < patches.size(); ++cell) {
      if (!(patches[cell].W > 1e-10)) continue;
      ++compared;
      // Second differences jump where a corner passes a wall; 1e-5 is what steps of 1e-7 m leave of it.
      test::ExpectJacobian(jacobians[cell], X_SB, 1e-7, 1e-5, [&](const Pose& X) { return calc(X).patches[cell]; });
    }
  }
  EXPECT_GT(compared, 20);
}

TEST_P(FacetIntegralsTest, CotangentsOfCorners) {
  const DepthField field = MakeField(GetParam());
  Random random(13);
  for (int trial = 0; trial < 60; ++trial) {
    const Triangle facet = MakeTriangle(&random, 0.012);
    std::vector<PatchCotangent> bar(static_cast<std::size_t>(CountCells(field)));
    for (PatchCotangent& b : bar) {
      b.F = random.Vec(1.0);
      b.M = random.Vec(100.0);
      b.W = random.U(-1.0, 1.0);
      b.m1 = random.Vec(100.0);
      const Matrix3d m = Matrix3d::NullaryExpr([&] { return random.U(-1e4, 1e4); });
      b.m2 = m + m.transpose();
    }
    const auto value = [&](const Triangle& f) {
      const std::vector<PatchIntegrals> patches = SumFacet(f, field).patches;
      double sum = 0.0;
      for (std::size_t c = 0; c < bar.size(); ++c) sum += bar[c].Pack().dot(test::Pack(patches[c]));
      return sum;
    };
    std::array<Vector3d, 3> bar_corners{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
    FacetRegions cut;
    CutFacet(0, Facet::Make(facet), field, &cut);
    for (const FacetRegion& region : cut.regions) {
      PullBackRegion(region, cut.walls, Facet::Make(facet), bar[static_cast<std::size_t>(region.cell)], &bar_corners);
    }
    double scale = 1e-9;
    for (const Vector3d& b : bar_corners) scale = std::max(scale, b.cwiseAbs().maxCoeff());
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) {
        const double h = 1e-7;
        const auto moved = [&](double s) {
          Triangle f = facet;
          f[k](i) += s * h;
          return value(f);
        };
        const double slope = (8.0 * (moved(1.0) - moved(-1.0)) - (moved(2.0) - moved(-2.0))) / (12.0 * h);
        EXPECT_NEAR(bar_corners[k](i), slope, 1e-5 * scale) << "corner " << k << ", axis " << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Fields, FacetIntegralsTest, testing::Range(0, 8));

// Gauss's rule of seven points [Abramowitz & Stegun, 25.4.29].
double SumByGauss(const std::function<double(double)>& f, double from, double to) {
  constexpr std::array<double, 4> kPlace = {0.0, 0.405845151377397, 0.741531185599394, 0.949107912342759};
  constexpr std::array<double, 4> kWeight = {0.417959183673469, 0.381830050505119, 0.279705391489277,
                                             0.129484966168870};
  const double middle = 0.5 * (from + to);
  const double half = 0.5 * (to - from);
  double sum = kWeight[0] * f(middle);
  for (std::size_t i = 1; i < kPlace.size(); ++i) {
    sum += kWeight[i] * (f(middle - half * kPlace[i]) + f(middle + half * kPlace[i]));
  }
  return half * sum;
}

// Halves what two halves do not confirm: `sum` is that of the whole. Forces have places where a derivative jumps.
double Integrate(const std::function<double(double)>& f, double from, double to, double sum, double tolerance) {
  const double middle = 0.5 * (from + to);
  const double left = SumByGauss(f, from, middle);
  const double right = SumByGauss(f, middle, to);
  if (std::abs(left + right - sum) <= tolerance || to - from < 1e-6) return left + right;
  return Integrate(f, from, middle, left, tolerance) + Integrate(f, middle, to, right, tolerance);
}

// A closed path between poses of the second body in the first's frame, and the contact's power along each side of it,
// which is passed in the time from 0 to 1.
class PathOfPoses {
 public:
  PathOfPoses(const ContactPair& pair, const std::array<Pose, 3>& corners)
      : sides_(MakeSides({pair})), first_body_(pair.bodies[0]), corners_(corners) {
    for (const ContactSide& side : sides_) near_.emplace_back(side);
  }

  double CalcPower(int leg, double s) {
    const Pose& from = corners_[static_cast<std::size_t>(leg)];
    const Pose& to = corners_[static_cast<std::size_t>((leg + 1) % 3)];
    const Eigen::AngleAxisd a(Matrix3d(to.R * from.R.transpose()));
    const Vector3d turn = a.angle() * a.axis();
    const Vector3d shift = to.p - from.p;
    const Pose X{ExpSo3(s * turn).toRotationMatrix() * from.R, from.p + s * shift};
    double power = 0.0;
    for (std::size_t k = 0; k < sides_.size(); ++k) {
      const bool first = sides_[k].body == first_body_;
      const Pose X_SB = first ? X : Pose{X.R.transpose(), -(X.R.transpose() * X.p)};
      SidePatches at;
      CalcPatches(sides_[k], &near_[k], X_SB, &at);
      Vector3d F = Vector3d::Zero();
      Vector3d M = Vector3d::Zero();
      for (const PatchIntegrals& p : at.patches) {
        F += p.F;
        M += p.M;
      }
      if (!first) {
        // On the other body, about its own origin, in its frame: seen from the first's frame with the sign turned.
        const Vector3d F_W = -(X.R * F);
        M = -(X.R * M) + X.p.cross(F_W);
        F = F_W;
      }
      // About the frame's origin: v = shift + turn × (x − p).
      power += F.dot(shift - turn.cross(X.p)) + M.dot(turn);
    }
    return power;
  }

  double CalcWork(int leg, double tolerance) {
    const auto power = [&](double s) { return CalcPower(leg, s); };
    double work = 0.0;
    constexpr int kParts = 8;
    for (int i = 0; i < kParts; ++i) {
      const double from = static_cast<double>(i) / kParts;
      const double to = static_cast<double>(i + 1) / kParts;
      work += Integrate(power, from, to, SumByGauss(power, from, to), tolerance);
    }
    return work;
  }

 private:
  std::vector<ContactSide> sides_;
  std::vector<NearFacets> near_;
  int first_body_;
  std::array<Pose, 3> corners_;
};

// A box in the field of another, of a half-space, of a round body: no net force acts along a closed path of poses, and
// the same holds for any pair of the table.
TEST(ContactEnergyTest, ClosedPathsOfPosesCostNothing) {
  const MeshGeometry mesh{std::make_shared<ContactMesh>(test::MakeWedge())};
  const MeshGeometry hull = *MakeConvexMesh(test::MakePyramid());
  const MeshGeometry designed = test::MakeDesigned(test::MakePyramid());
  TriangleMesh dented = test::MakeRoundHull(0.01, 1);
  dented.vertices[7] *= 0.6;
  const MeshGeometry bent = test::MakeDesigned(dented);
  const BoxGeometry box{{0.01, 0.006, 0.008}, {0.001, 0.0, 0.0}};
  const SphereGeometry sphere{0.007, {0.0, 0.001, 0.0}};
  const CapsuleGeometry capsule{0.005, 0.012, {0.0, 0.0, 0.001}};
  const CylinderGeometry cylinder{0.006, 0.008, {0.0, 0.001, 0.0}};
  const CylinderGeometry coin{0.009, 0.0015, {0.0, 0.001, 0.0}};
  const std::vector<std::array<ContactGeometry, 2>> pairs = {{box, HalfSpaceGeometry{}},
                                                             {mesh, HalfSpaceGeometry{}},
                                                             {sphere, HalfSpaceGeometry{}},
                                                             {capsule, HalfSpaceGeometry{}},
                                                             {cylinder, HalfSpaceGeometry{}},
                                                             {box, box},
                                                             {mesh, box},
                                                             {mesh, sphere},
                                                             {mesh, capsule},
                                                             {box, sphere},
                                                             {box, capsule},
                                                             {mesh, cylinder},
                                                             {box, cylinder},
                                                             {box, coin},
                                                             {sphere, sphere},
                                                             {capsule, sphere},
                                                             {capsule, capsule},
                                                             {hull, HalfSpaceGeometry{}},
                                                             {mesh, hull},
                                                             {hull, box},
                                                             {hull, hull},
                                                             {hull, sphere},
                                                             {hull, capsule},
                                                             {hull, coin},
                                                             {cylinder, sphere},
                                                             {coin, capsule},
                                                             {coin, cylinder},
                                                             {designed, designed},
                                                             {bent, designed}};
  Random random(5);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    // Where hundreds of facets come and go the power bends as often, and its integral takes seconds.
    const int trials =
        std::holds_alternative<CylinderGeometry>(pairs[p][0]) && !std::holds_alternative<HalfSpaceGeometry>(pairs[p][1])
            ? 1
            : 5;
    ContactPair pair;
    pair.bodies = {0, 1};
    pair.shapes = pairs[p];
    pair.material.stiffness = 1e9;
    double largest = 0.0;
    for (int trial = 0; trial < trials; ++trial) {
      const double lift = std::holds_alternative<HalfSpaceGeometry>(pairs[p][1]) ? 0.005 : 0.009;
      std::array<Pose, 3> at;
      for (Pose& X : at) {
        X = random.MakePose(0.6, 0.002);
        X.p.z() += lift;
      }
      PathOfPoses path(pair, at);
      std::array<double, 3> work{};
      for (int leg = 0; leg < 3; ++leg) {
        const double rough = path.CalcWork(leg, std::numeric_limits<double>::infinity());
        largest = std::max(largest, std::abs(rough));
      }
      for (int leg = 0; leg < 3; ++leg) work[static_cast<std::size_t>(leg)] = path.CalcWork(leg, 1e-12 * largest);
      EXPECT_LE(std::abs(work[0] + work[1] + work[2]), 1e-9 * largest) << "pair " << p << ", trial " << trial;
    }
    EXPECT_GT(largest, 1e-6) << "pair " << p;
  }
}

}  // namespace
}  // namespace knap
