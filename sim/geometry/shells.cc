#include "sim/geometry/shells.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "sim/geometry/winding_number.h"

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// The triangles' pieces, as trees that lead to their first triangle.
class Pieces {
 public:
  explicit Pieces(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

  int FindFirst(int i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      i = parent_[static_cast<std::size_t>(i)] =
          parent_[static_cast<std::size_t>(parent_[static_cast<std::size_t>(i)])];
    }
    return i;
  }

  void Join(int i, int j) {
    const int a = FindFirst(i);
    const int b = FindFirst(j);
    parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

double CalcVolume(const TriangleMesh& mesh, const Shell& shell) {
  const Vector3d centre = shell.box.center();
  double sum = 0.0;
  for (const int i : shell.triangles) {
    const Vector3i& t = mesh.triangles[static_cast<std::size_t>(i)];
    const Vector3d a = mesh.vertices[t[0]] - centre;
    const Vector3d b = mesh.vertices[t[1]] - centre;
    const Vector3d c = mesh.vertices[t[2]] - centre;
    sum += a.dot(b.cross(c));
  }
  return sum / 6.0;
}

// Whether `inner`, which does not meet `outer`, lies inside it.
bool IsInside(const TriangleMesh& mesh, const Shell& inner, const Shell& outer) {
  if (!outer.box.contains(inner.box)) return false;
  const Vector3d& p = mesh.vertices[mesh.triangles[static_cast<std::size_t>(inner.triangles.front())][0]];
  return std::abs(CalcWindingNumber(mesh, outer.triangles, p)) > 0.5;
}

}  // namespace

std::vector<Shell> FindShells(const TriangleMesh& mesh) {
  struct EdgeUse {
    int low, high, triangle;
  };
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vector3i& t = mesh.triangles[i];
    for (int k = 0; k < 3; ++k) {
      const int from = t[k];
      const int to = t[(k + 1) % 3];
      uses.push_back({std::min(from, to), std::max(from, to), static_cast<int>(i)});
    }
  }
  std::sort(uses.begin(), uses.end(),
            [](const EdgeUse& a, const EdgeUse& b) { return std::pair(a.low, a.high) < std::pair(b.low, b.high); });
  Pieces pieces(mesh.triangles.size());
  for (std::size_t i = 1; i < uses.size(); ++i) {
    if (uses[i - 1].low == uses[i].low && uses[i - 1].high == uses[i].high) {
      pieces.Join(uses[i - 1].triangle, uses[i].triangle);
    }
  }
  std::vector<Shell> shells;
  std::vector<int> shell_of(mesh.triangles.size(), -1);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto first = static_cast<std::size_t>(pieces.FindFirst(static_cast<int>(i)));
    if (first == i) {
      shell_of[i] = static_cast<int>(shells.size());
      shells.emplace_back();
    }
    shell_of[i] = shell_of[first];
    Shell& shell = shells[static_cast<std::size_t>(shell_of[i])];
    shell.triangles.push_back(static_cast<int>(i));
    for (int k = 0; k < 3; ++k) shell.box.extend(mesh.vertices[mesh.triangles[i][k]]);
  }
  for (Shell& shell : shells) shell.volume = CalcVolume(mesh, shell);
  return shells;
}

std::string DescribeShell(const std::vector<Shell>& shells, int index) {
  const Shell& shell = shells[static_cast<std::size_t>(index)];
  const Vector3d a = 1000.0 * shell.box.min();
  const Vector3d b = 1000.0 * shell.box.max();
  return fmt::format("part {} of {} ({} triangles, from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g}) mm)",
                     index + 1, shells.size(), shell.triangles.size(), a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
}

std::string FindWrongShell(const TriangleMesh& mesh, const std::vector<Shell>& shells) {
  for (int i = 0; i < static_cast<int>(shells.size()); ++i) {
    const Shell& shell = shells[static_cast<std::size_t>(i)];
    int depth = 0;
    int around = -1;  // the smallest shell that it lies in
    for (int j = 0; j < static_cast<int>(shells.size()); ++j) {
      const Shell& other = shells[static_cast<std::size_t>(j)];
      if (j == i || !IsInside(mesh, shell, other)) continue;
      ++depth;
      const bool nearer =
          around < 0 || std::abs(other.volume) < std::abs(shells[static_cast<std::size_t>(around)].volume);
      if (nearer) around = j;
    }
    const bool is_cavity = depth % 2 == 1;
    if (is_cavity && shell.volume < 0.0) continue;
    if (!is_cavity && shell.volume > 0.0) continue;
    const std::string name = DescribeShell(shells, i);
    if (depth == 0) return fmt::format("{} faces inwards and lies in no other", name);
    if (is_cavity) {
      return fmt::format("{} faces outwards and lies inside {}; a cavity faces inwards", name,
                         DescribeShell(shells, around));
    }
    return fmt::format("{} faces inwards and lies inside {}, which does too", name, DescribeShell(shells, around));
  }
  return {};
}

}  // namespace knap
