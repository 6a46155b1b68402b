#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Exporter.hpp>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "sim/geometry/mesh_io.h"

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

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

std::string WriteStl(const TriangleMesh& mesh) {
  const double volume = CalcSignedVolume(mesh);
  if (!(volume > 0.0)) {
    throw std::runtime_error(
        fmt::format("a mesh of {:.6g} mm^3 is not written as STL: it is inside out or empty", 1e9 * volume));
  }
  return Export(mesh, 1000, "stlb");
}

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
