#include "sim/geometry/mesh_io.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Exporter.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <new>
#include <stdexcept>
#include <string_view>

#include "sim/geometry/mesh_text.h"

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr size_t kStlHeaderSize = 80;
constexpr size_t kStlFacetsBegin = kStlHeaderSize + 4;
constexpr size_t kStlFacetSize = 50;  // normal and three corners in floats, and two bytes

// Vertex numbers travel through assimp in single-precision texture coordinates, which are exact below 2^24.
constexpr size_t kMaxObjVertices = size_t{1} << 24;

[[noreturn]] void Fail(const std::string& name, const std::string& what) {
  throw std::runtime_error(fmt::format("{}: {}", name, what));
}

// Keeps assimp from following references to other files (materials, textures).
class NoFiles final : public Assimp::IOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
  void Close(Assimp::IOStream*) override {}
};

// Calls use(mesh) for every mesh that assimp makes of `bytes`, all faces of which are triangles.
template <typename Use>
void ImportTriangles(const std::string& name, std::string_view bytes, const char* format, const Use& use) {
  Assimp::Importer importer;
  importer.SetIOHandler(new NoFiles);  // the importer owns and deletes it
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, format);
  // Assimp catches everything and keeps its text alone.
  const std::string_view error = importer.GetErrorString();
  if (scene == nullptr && error.find("bad_alloc") != std::string_view::npos) throw std::bad_alloc();
  if (scene == nullptr) Fail(name, importer.GetErrorString());
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) use(*scene->mMeshes[i]);
}

// Merges vertices with equal coordinates, keeping the first of each and the order.
TriangleMesh Weld(const TriangleMesh& mesh) {
  TriangleMesh welded;
  std::map<std::array<double, 3>, int> known;
  std::vector<int> new_index;
  new_index.reserve(mesh.vertices.size());
  for (const Vector3d& v : mesh.vertices) {
    // Adding zero turns -0 into 0, which is equal but prints otherwise.
    const auto [entry, is_new] =
        known.try_emplace({v.x() + 0.0, v.y() + 0.0, v.z() + 0.0}, static_cast<int>(welded.vertices.size()));
    if (is_new) welded.vertices.emplace_back(entry->first[0], entry->first[1], entry->first[2]);
    new_index.push_back(entry->second);
  }
  for (const Vector3i& t : mesh.triangles) {
    const Vector3i u(new_index[t[0]], new_index[t[1]], new_index[t[2]]);
    if (u[0] != u[1] && u[1] != u[2] && u[2] != u[0]) welded.triangles.push_back(u);
  }
  return welded;
}

TriangleMesh ReadObj(const std::string& name, std::string_view bytes) {
  ObjSurface surface = ParseObjSurface(name, bytes);
  if (surface.vertices.size() > kMaxObjVertices) {
    Fail(name, fmt::format("{} vertices; at most {}", surface.vertices.size(), kMaxObjVertices));
  }
  // Assimp splits the polygons, but renumbers vertices and knows single precision only. So it is handed the
  // bare surface, with every vertex's number as its texture coordinate, and only these numbers are taken.
  std::string bare;
  for (size_t i = 0; i < surface.vertices.size(); ++i) {
    const Vector3d& v = surface.vertices[i];
    bare += fmt::format("v {:.9g} {:.9g} {:.9g}\nvt {} 0\n", v.x(), v.y(), v.z(), i);
  }
  size_t expected_triangles = 0;
  for (const std::vector<int>& polygon : surface.polygons) {
    bare += 'f';
    for (const int index : polygon) bare += fmt::format(" {0}/{0}", index + 1);
    bare += '\n';
    expected_triangles += polygon.size() - 2;
  }
  TriangleMesh mesh;
  mesh.vertices = std::move(surface.vertices);
  if (surface.polygons.empty()) return mesh;
  ImportTriangles(name, bare, "obj", [&mesh](const aiMesh& part) {
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;
      Vector3i t;
      for (int k = 0; k < 3; ++k) t[k] = static_cast<int>(part.mTextureCoords[0][face.mIndices[k]].x);
      mesh.triangles.push_back(t);
    }
  });
  if (mesh.triangles.size() != expected_triangles) Fail(name, "a polygon cannot be split into triangles");
  return Weld(mesh);
}

// A binary STL says how many facets it has, and so how long it is; its header may begin with "solid" too.
bool IsBinaryStl(std::string_view bytes) {
  if (bytes.size() < kStlFacetsBegin) return false;
  const auto byte = [&bytes](size_t i) { return std::uint64_t{static_cast<unsigned char>(bytes[kStlHeaderSize + i])}; };
  const std::uint64_t num_facets = byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24;
  return bytes.size() == kStlFacetsBegin + kStlFacetSize * num_facets;
}

TriangleMesh ReadStl(const std::string& name, std::string_view bytes) {
  std::string clean(bytes);
  if (IsBinaryStl(bytes)) {
    std::fill_n(clean.begin(), kStlHeaderSize, ' ');  // a "COLOR=" there would only concern assimp
    if (bytes.size() == kStlFacetsBegin) return {};
  } else if (bytes.substr(0, 5) == "solid") {
    CheckTextStl(name, bytes);
  } else {
    Fail(name, fmt::format("neither a text STL nor a complete binary one ({} bytes)", bytes.size()));
  }
  TriangleMesh mesh;
  ImportTriangles(name, clean, "stl", [&](const aiMesh& part) {
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;
      const int first = static_cast<int>(mesh.vertices.size());
      for (int k = 0; k < 3; ++k) {
        const aiVector3D& v = part.mVertices[face.mIndices[k]];
        mesh.vertices.emplace_back(v.x, v.y, v.z);
        if (!mesh.vertices.back().allFinite()) Fail(name, fmt::format("facet {} has a corner that is not finite", i));
      }
      mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
  });
  return Weld(mesh);
}

// Builds assimp's scene of one mesh with three vertices of its own and a normal for every triangle.
std::unique_ptr<aiScene> MakeScene(const TriangleMesh& mesh, double units_per_metre) {
  auto scene = std::make_unique<aiScene>();
  scene->mRootNode = new aiNode;
  scene->mRootNode->mNumMeshes = 1;
  scene->mRootNode->mMeshes = new unsigned[1]{0};
  scene->mNumMaterials = 1;
  scene->mMaterials = new aiMaterial* [1] { new aiMaterial };
  auto* out = new aiMesh;
  scene->mNumMeshes = 1;
  scene->mMeshes = new aiMesh* [1] { out };

  out->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  out->mNumFaces = static_cast<unsigned>(mesh.triangles.size());
  out->mFaces = new aiFace[out->mNumFaces];
  out->mNumVertices = 3 * out->mNumFaces;
  out->mVertices = new aiVector3D[out->mNumVertices];
  out->mNormals = new aiVector3D[out->mNumVertices];
  const auto to_assimp = [](const Vector3d& v) {
    return aiVector3D(static_cast<ai_real>(v.x()), static_cast<ai_real>(v.y()), static_cast<ai_real>(v.z()));
  };
  for (unsigned i = 0; i < out->mNumFaces; ++i) {
    const Vector3i& t = mesh.triangles[i];
    const Vector3d& a = mesh.vertices[t[0]];
    const Vector3d normal = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).stableNormalized();
    aiFace& face = out->mFaces[i];
    face.mNumIndices = 3;
    face.mIndices = new unsigned[3]{3 * i, 3 * i + 1, 3 * i + 2};
    for (int k = 0; k < 3; ++k) {
      out->mVertices[3 * i + k] = to_assimp(mesh.vertices[t[k]] * units_per_metre);
      out->mNormals[3 * i + k] = to_assimp(normal);
    }
  }
  return scene;
}

std::string Export(const TriangleMesh& mesh, double units_per_metre, const char* format) {
  const std::unique_ptr<aiScene> scene = MakeScene(mesh, units_per_metre);
  Assimp::Exporter exporter;
  const aiExportDataBlob* blob = exporter.ExportToBlob(scene.get(), format);
  if (blob == nullptr)
    throw std::runtime_error(fmt::format("cannot export a mesh as {}: {}", format, exporter.GetErrorString()));
  return std::string(static_cast<const char*>(blob->data), blob->size);
}

}  // namespace

TriangleMesh ReadMesh(const std::string& name, std::string_view bytes, double metres_per_unit) {
  std::string ending = std::filesystem::path(name).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
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

std::string WriteStl(const TriangleMesh& mesh) { return Export(mesh, 1000, "stlb"); }

std::string WriteObj(const TriangleMesh& mesh, double metres_per_unit) {
  return Export(mesh, 1 / metres_per_unit, "objnomtl");
}

void WriteFile(const std::filesystem::path& path, std::string_view bytes) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw std::runtime_error(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
}

}  // namespace knap
