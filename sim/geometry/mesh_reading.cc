#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "sim/geometry/mesh_io.h"
#include "sim/geometry/mesh_text.h"
#include "sim/geometry/polygon.h"
#include "sim/geometry/word_reader.h"

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr std::size_t kStlHeaderSize = 80;
constexpr std::size_t kStlFacetsBegin = kStlHeaderSize + 4;
constexpr std::size_t kStlFacetSize = 50;  // normal and three corners in floats, and two bytes

[[noreturn]] void Fail(const std::string& name, const std::string& what) {
  throw std::runtime_error(fmt::format("{}: {}", name, what));
}

// Vertices with equal coordinates become one: the first of each is kept, in the order of the file.
struct WeldedVertices {
  std::vector<Vector3d> vertices;
  std::vector<int> new_index;
};

WeldedVertices Weld(const std::vector<Vector3d>& vertices) {
  WeldedVertices welded;
  std::map<std::array<double, 3>, int> known;
  welded.new_index.reserve(vertices.size());
  for (const Vector3d& v : vertices) {
    // Adding zero turns -0 into 0, which is equal but prints otherwise.
    const auto [entry, is_new] =
        known.try_emplace({v.x() + 0.0, v.y() + 0.0, v.z() + 0.0}, static_cast<int>(welded.vertices.size()));
    if (is_new) welded.vertices.emplace_back(entry->first[0], entry->first[1], entry->first[2]);
    welded.new_index.push_back(entry->second);
  }
  return welded;
}

TriangleMesh ReadObj(const std::string& name, std::string_view bytes) {
  const ObjSurface surface = ParseObjSurface(name, bytes);
  WeldedVertices welded = Weld(surface.vertices);
  TriangleMesh mesh;
  mesh.vertices = std::move(welded.vertices);
  for (const ObjPolygon& polygon : surface.polygons) {
    std::vector<int> outline;  // without edges that have lost their length
    for (const int corner : polygon.corners) {
      const int index = welded.new_index[static_cast<std::size_t>(corner)];
      if (outline.empty() || outline.back() != index) outline.push_back(index);
    }
    while (outline.size() > 1 && outline.back() == outline.front()) outline.pop_back();
    if (outline.size() < 3) continue;
    std::vector<Vector3d> corners;
    corners.reserve(outline.size());
    for (const int index : outline) corners.push_back(mesh.vertices[static_cast<std::size_t>(index)]);
    const PolygonSplit split = SplitPolygon(corners);
    if (!split.fault.empty()) {
      throw std::runtime_error(
          fmt::format("{}:{}: a face that cannot be split into triangles: {}", name, polygon.line, split.fault));
    }
    for (const Vector3i& t : split.triangles) mesh.triangles.emplace_back(outline[t[0]], outline[t[1]], outline[t[2]]);
  }
  return mesh;
}

// As many facets as a binary STL says it has; its header may begin with "solid" too, and some programs write more
// behind the facets. Empty when the file is shorter: no text has a length here that it could have.
std::optional<std::uint32_t> CountBinaryFacets(std::string_view bytes) {
  if (bytes.size() < kStlFacetsBegin) return {};
  const auto byte = [&bytes](std::size_t i) {
    return std::uint32_t{static_cast<unsigned char>(bytes[kStlHeaderSize + i])};
  };
  const std::uint32_t facets = byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24;
  if ((bytes.size() - kStlFacetsBegin) / kStlFacetSize < facets) return {};
  return facets;
}

TriangleMesh ReadBinaryStl(const std::string& name, std::string_view bytes, std::uint32_t facets) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < facets; ++i) {
    const char* facet = bytes.data() + kStlFacetsBegin + kStlFacetSize * i;
    std::array<float, 9> corners;  // behind the normal; little-endian, as are all machines that we run on
    std::memcpy(corners.data(), facet + 12, sizeof corners);
    const int first = static_cast<int>(mesh.vertices.size());
    for (std::size_t k = 0; k < 3; ++k) {
      mesh.vertices.emplace_back(corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]);
      if (!mesh.vertices.back().allFinite()) Fail(name, fmt::format("facet {} has a corner that is not finite", i));
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

TriangleMesh ReadStl(const std::string& name, std::string_view bytes) {
  TriangleMesh mesh;
  if (const std::optional<std::uint32_t> facets = CountBinaryFacets(bytes)) {
    mesh = ReadBinaryStl(name, bytes, *facets);
  } else if (BeginsAsTextStl(bytes)) {
    mesh = ParseTextStl(name, bytes);
  } else {
    Fail(name, fmt::format("neither a text STL nor a complete binary one ({} bytes)", bytes.size()));
  }
  WeldedVertices welded = Weld(mesh.vertices);
  mesh.vertices = std::move(welded.vertices);
  std::vector<Vector3i> whole;  // triangles that have not lost a corner
  for (const Vector3i& t : mesh.triangles) {
    const Vector3i u(welded.new_index[t[0]], welded.new_index[t[1]], welded.new_index[t[2]]);
    if (u[0] != u[1] && u[1] != u[2] && u[2] != u[0]) whole.push_back(u);
  }
  mesh.triangles = std::move(whole);
  return mesh;
}

}  // namespace

TriangleMesh ReadMesh(const std::string& name, std::string_view bytes, double metres_per_unit) {
  const std::string ending = ToLowerCase(std::filesystem::path(name).extension().string());
  if (ending != ".obj" && ending != ".stl") {
    Fail(name, fmt::format("cannot read '{}' files as meshes; save it as .obj or .stl", ending));
  }
  if (!(metres_per_unit > 0) || !std::isfinite(metres_per_unit)) {
    Fail(name, fmt::format("a unit of {} m; it must be positive and finite", metres_per_unit));
  }
  TriangleMesh mesh = ending == ".obj" ? ReadObj(name, bytes) : ReadStl(name, bytes);
  if (mesh.triangles.empty()) Fail(name, "no triangles in the file");
  for (Vector3d& v : mesh.vertices) v *= metres_per_unit;
  return mesh;
}

}  // namespace knap
