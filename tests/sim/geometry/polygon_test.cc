#include "sim/geometry/polygon.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "sim/geometry/mesh_io.h"

namespace knap {
namespace polygon_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using ::testing::HasSubstr;
using Outline = std::vector<Vector2d>;

double CalcCross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double CalcArea(const Outline& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) twice += CalcCross(outline[i], outline[(i + 1) % outline.size()]);
  return 0.5 * twice;
}

// By the crossings of a ray along x.
bool IsInside(const Outline& outline, const Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d& a = outline[i];
    const Vector2d& b = outline[(i + 1) % outline.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()) > p.x()) inside = !inside;
  }
  return inside;
}

double Draw(std::mt19937_64* random, double low, double high) {
  return low + (high - low) * static_cast<double>((*random)() >> 11) * 0x1p-53;
}

// Random points in an order without crossings: two edges that cross are uncrossed by reversing what is between them,
// which makes the outline shorter and so comes to an end. Then more corners in line with others, a random first one.
Outline MakeOutline(std::mt19937_64* random) {
  const std::size_t n = 4 + (*random)() % 12;
  Outline outline;
  for (std::size_t i = 0; i < n; ++i) outline.emplace_back(Draw(random, -1, 1), Draw(random, -1, 1));
  const auto left = [&](std::size_t i, std::size_t j) {
    return CalcCross(outline[(i + 1) % n] - outline[i], outline[j % n] - outline[i]) > 0.0;
  };
  for (bool crossed = true; crossed;) {
    crossed = false;
    for (std::size_t i = 0; i + 2 < n && !crossed; ++i) {
      for (std::size_t j = i + 2; j < n && !crossed; ++j) {
        if ((j + 1) % n == i) continue;
        crossed = left(i, j) != left(i, j + 1) && left(j, i) != left(j, i + 1);
        if (crossed) {
          std::reverse(outline.begin() + static_cast<std::ptrdiff_t>(i + 1),
                       outline.begin() + static_cast<std::ptrdiff_t>(j + 1));
        }
      }
    }
  }
  if (CalcArea(outline) < 0.0) std::reverse(outline.begin(), outline.end());
  Outline finer;
  for (std::size_t i = 0; i < n; ++i) {
    finer.push_back(outline[i]);
    const std::size_t more = (*random)() % 3;
    for (std::size_t k = 1; k <= more; ++k) {
      const double s = static_cast<double>(k) / static_cast<double>(more + 1);
      finer.push_back((1.0 - s) * outline[i] + s * outline[(i + 1) % n]);
    }
  }
  std::rotate(finer.begin(), finer.begin() + static_cast<std::ptrdiff_t>((*random)() % finer.size()), finer.end());
  return finer;
}

Eigen::Matrix3d DrawRotation(std::mt19937_64* random) {
  Eigen::Vector4d q;
  for (double& x : q) x = Draw(random, -1, 1);
  return Eigen::Quaterniond(q.normalized()).toRotationMatrix();
}

// Against other rules than that of ears: the area, and rays.
TEST(SplitPolygon, CoversRandomOutlinesOnceAndNothingElse) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const Outline outline = MakeOutline(&random);
    const Eigen::Matrix3d R = DrawRotation(&random);
    std::vector<Vector3d> corners;
    for (const Vector2d& p : outline) corners.emplace_back(R * Vector3d(p.x(), p.y(), 0.3));
    const PolygonSplit split = SplitPolygon(corners);
    ASSERT_EQ(split.fault, "") << trial;
    ASSERT_EQ(split.triangles.size(), outline.size() - 2);
    double sum = 0.0;
    for (const Vector3i& t : split.triangles) {
      const Outline triangle = {outline[t[0]], outline[t[1]], outline[t[2]]};
      const double area = CalcArea(triangle);
      ASSERT_GT(area, 0.0) << trial;
      sum += area;
      // Seen from a little inside each corner and from the middle. Slivers cannot be told by rays.
      const Vector2d middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
      if (area < 1e-9) continue;
      ASSERT_TRUE(IsInside(outline, middle)) << trial;
      for (const Vector2d& corner : triangle) ASSERT_TRUE(IsInside(outline, 0.999 * corner + 0.001 * middle)) << trial;
    }
    ASSERT_NEAR(sum, CalcArea(outline), 1e-12) << trial;
  }
}

// Through the reader, with everything that is asked of a body: closed, no self-contact, the right volume.
TEST(SplitPolygon, MakesSoundPrismsOfRandomOutlines) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Outline outline = MakeOutline(&random);
    const Eigen::Matrix3d R = DrawRotation(&random);
    const std::size_t n = outline.size();
    std::string text, bottom = "f", top = "f", sides;
    for (const double z : {0.0, 0.5}) {
      for (const Vector2d& p : outline) {
        const Vector3d v = R * Vector3d(p.x(), p.y(), z);
        text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      bottom += fmt::format(" {}", n - i);
      top += fmt::format(" {}", n + i + 1);
      const std::size_t next = (i + 1) % n;
      sides += fmt::format("f {} {} {} {}\n", i + 1, next + 1, n + next + 1, n + i + 1);
    }
    const TriangleMesh mesh = ReadMesh("prism.obj", text + bottom + "\n" + top + "\n" + sides, 1);
    ASSERT_EQ(FindDefects(mesh).Describe(), "") << trial;
    ASSERT_NEAR(CalcSignedVolume(mesh), 0.5 * CalcArea(outline), 1e-12) << trial;
  }
}

TEST(SplitPolygon, LetsAnyCornerOfAnOutlineWithCornersInLineBeTheFirst) {
  // A square of which every side has three corners more, and a notch in one.
  const Outline outline = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {4, 1}, {4, 2}, {4, 3}, {4, 4},
                           {3, 4}, {3, 1}, {2, 1}, {1, 1}, {1, 4}, {0, 4}, {0, 3}, {0, 2}, {0, 1}};
  for (std::size_t first = 0; first < outline.size(); ++first) {
    std::vector<Vector3d> corners;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vector2d& p = outline[(first + i) % outline.size()];
      corners.emplace_back(p.x(), p.y(), 0);
    }
    const PolygonSplit split = SplitPolygon(corners);
    ASSERT_EQ(split.fault, "");
    double area = 0.0;
    for (const Vector3i& t : split.triangles) {
      const double twice = (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).z();
      EXPECT_GT(twice, 0.0);
      area += 0.5 * twice;
    }
    EXPECT_DOUBLE_EQ(area, 16 - 6);
  }
}

TEST(SplitPolygon, TakesAHoleOverABridge) {
  const std::vector<Vector3d> corners = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                                         {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  const PolygonSplit split = SplitPolygon(corners);
  ASSERT_EQ(split.fault, "");
  double area = 0.0;
  for (const Vector3i& t : split.triangles) {
    const double twice = (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).z();
    EXPECT_GT(twice, 0.0);
    area += 0.5 * twice;
  }
  EXPECT_DOUBLE_EQ(area, 16 - 4);
}

TEST(SplitPolygon, RefusesWhatIsNoPolygon) {
  EXPECT_THAT(SplitPolygon({{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 1, 0}}).fault, HasSubstr("crosses itself"));
  EXPECT_THAT(SplitPolygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}).fault, HasSubstr("no area"));
  try {
    ReadMesh("bow.obj", "v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 1 0\n\nf 1 2 3 4\n", 1);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(),
                 "bow.obj:6: a face that cannot be split into triangles: the outline crosses itself: the edge behind "
                 "corner 1 and the one behind corner 3");
  }
}

}  // namespace polygon_test
}  // namespace knap
