#include <assimp/scene.h>
#include <fmt/format.h>

#include <array>
#include <assimp/Exporter.hpp>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

#include "sim/geometry/mesh_io.h"
#include "sim/geometry/print_file.h"
#include "sim/geometry/threemf.h"

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

aiVector3D ToAssimp(const Vector3d& v) {
  return {static_cast<ai_real>(v.x()), static_cast<ai_real>(v.y()), static_cast<ai_real>(v.z())};
}

// A scene of an empty mesh and the one node that has it.
std::unique_ptr<aiScene> MakeEmptyScene(const std::string& name) {
  auto scene = std::make_unique<aiScene>();
  scene->mRootNode = new aiNode(name);
  scene->mRootNode->mNumMeshes = 1;
  scene->mRootNode->mMeshes = new unsigned[1]{0};
  scene->mNumMaterials = 1;
  scene->mMaterials = new aiMaterial* [1] { new aiMaterial };
  scene->mNumMeshes = 1;
  scene->mMeshes = new aiMesh* [1] { new aiMesh };
  scene->mMeshes[0]->mName = name;
  scene->mMeshes[0]->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  return scene;
}

// One mesh, in millimetres, with three vertices of its own and a normal for every triangle.
std::unique_ptr<aiScene> MakeFacetScene(const TriangleMesh& mesh) {
  std::unique_ptr<aiScene> scene = MakeEmptyScene("");
  aiMesh* out = scene->mMeshes[0];
  out->mNumFaces = static_cast<unsigned>(mesh.triangles.size());
  out->mFaces = new aiFace[out->mNumFaces];
  out->mNumVertices = 3 * out->mNumFaces;
  out->mVertices = new aiVector3D[out->mNumVertices];
  out->mNormals = new aiVector3D[out->mNumVertices];
  for (unsigned i = 0; i < out->mNumFaces; ++i) {
    const Vector3i& t = mesh.triangles[i];
    const Vector3d& a = mesh.vertices[t[0]];
    const Vector3d normal = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).stableNormalized();
    aiFace& face = out->mFaces[i];
    face.mNumIndices = 3;
    face.mIndices = new unsigned[3]{3 * i, 3 * i + 1, 3 * i + 2};
    for (int k = 0; k < 3; ++k) {
      out->mVertices[3 * i + k] = ToAssimp(mesh.vertices[t[k]] * 1000.0);
      out->mNormals[3 * i + k] = ToAssimp(normal);
    }
  }
  return scene;
}

// One mesh of shared vertices without normals, which viewers then take to be flat, and a node that turns z up into y
// up.
std::unique_ptr<aiScene> MakeViewedScene(const TriangleMesh& mesh, const std::string& name) {
  std::unique_ptr<aiScene> scene = MakeEmptyScene(name);
  scene->mRootNode->mTransformation = aiMatrix4x4(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1);
  aiMesh* out = scene->mMeshes[0];
  out->mNumVertices = static_cast<unsigned>(mesh.vertices.size());
  out->mVertices = new aiVector3D[out->mNumVertices];
  for (unsigned i = 0; i < out->mNumVertices; ++i) out->mVertices[i] = ToAssimp(mesh.vertices[i]);
  out->mNumFaces = static_cast<unsigned>(mesh.triangles.size());
  out->mFaces = new aiFace[out->mNumFaces];
  for (unsigned i = 0; i < out->mNumFaces; ++i) {
    const Vector3i& t = mesh.triangles[i];
    out->mFaces[i].mNumIndices = 3;
    out->mFaces[i].mIndices =
        new unsigned[3]{static_cast<unsigned>(t[0]), static_cast<unsigned>(t[1]), static_cast<unsigned>(t[2])};
  }
  return scene;
}

std::string Export(const aiScene& scene, const char* format) {
  Assimp::Exporter exporter;
  const aiExportDataBlob* blob = exporter.ExportToBlob(&scene, format);
  if (blob == nullptr)
    throw std::runtime_error(fmt::format("cannot export a mesh as {}: {}", format, exporter.GetErrorString()));
  return std::string(static_cast<const char*>(blob->data), blob->size);
}

}  // namespace

std::string WriteStl(const TriangleMesh& mesh) { return WritePrintFile(mesh, PrintFormat::kStl, ""); }

std::string WriteObj(const TriangleMesh& mesh, double metres_per_unit) {
  // Assimp numbers vertices anew, by what its triangles meet first.
  std::string text;
  const auto out = std::back_inserter(text);
  for (const Vector3d& v : mesh.vertices) {
    const Vector3d p = v / metres_per_unit;
    fmt::format_to(out, "v {:.9g} {:.9g} {:.9g}\n", p.x(), p.y(), p.z());
  }
  for (const Vector3i& t : mesh.triangles) fmt::format_to(out, "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

namespace {

constexpr std::array<std::string_view, 4> kFormatNames = {"stl", "3mf", "obj", "glb"};

}  // namespace

std::string_view GetName(PrintFormat format) { return kFormatNames[static_cast<std::size_t>(format)]; }

std::optional<PrintFormat> FindPrintFormat(std::string_view name) {
  for (std::size_t i = 0; i < kFormatNames.size(); ++i) {
    if (kFormatNames[i] == name) return static_cast<PrintFormat>(i);
  }
  return std::nullopt;
}

TriangleMesh RoundAsWritten(const TriangleMesh& mesh, PrintFormat format) {
  const double units_per_metre = format == PrintFormat::kGlb ? 1.0 : 1000.0;
  TriangleMesh out = mesh;
  for (Vector3d& v : out.vertices) v = (v * units_per_metre).cast<float>().cast<double>() / units_per_metre;
  return out;
}

std::string WritePrintFile(const TriangleMesh& unrounded, PrintFormat format, const std::string& name) {
  // Normals are those of what is written.
  const TriangleMesh mesh = RoundAsWritten(unrounded, format);
  const double volume = CalcSignedVolume(mesh);
  if (!(volume > 0.0)) {
    throw std::runtime_error(fmt::format("a mesh of {:.6g} mm^3 is not written as {}: it is inside out or empty",
                                         1e9 * volume, GetName(format)));
  }
  switch (format) {
    case PrintFormat::kStl:
      return Export(*MakeFacetScene(mesh), "stlb");
    case PrintFormat::k3mf:
      return Write3mf(mesh, name);
    case PrintFormat::kObj:
      return WriteObj(mesh, 0.001);
    case PrintFormat::kGlb:
      return Export(*MakeViewedScene(mesh, name), "glb2");
  }
  throw std::runtime_error("no such format");
}

void WriteFile(const std::filesystem::path& path, std::string_view bytes) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw std::runtime_error(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
}

}  // namespace knap
