// Mesh files, which come from any program: the first byte of an input chooses between OBJ and STL.
#include <algorithm>
#include <stdexcept>

#include "sim/geometry/mesh_io.h"
#include "tests/fuzz/fuzz_target.h"

std::vector<std::string> MakeSeeds() {
  std::string binary = "s" + std::string(84, '\0');
  binary[81] = 1;
  for (int k = 0; k < 48; ++k) binary += static_cast<char>(k % 4 == 3 ? 0x3f + k / 12 : k);
  binary += std::string(2, '\0');
  return {
      "ov 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
      "ov -1 -1 0\nv 1 0 0\nv -1 1 0\nv 0 0 0\nv 0 0 -2\nf 3/1 4//2 1/1/1 \\\n-4\nf 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n",
      "of 1 2 3 4 5 6 7 8\rv 0 0 0\rv 1 0 0\rv 2 0 0\rv 2 1 0\rv 2 2 0\rv 1 2 0\rv 1 1 0\rv 0 1 0\rlod 1\r",
      "o\xef\xbb\xbf"
      "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nv 1 1 1\nv 3 1 1\nv 1 3 1\nv 1 1 3\n"
      "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n",
      "ssolid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid\n",
      binary};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string name = data[0] % 2 == 0 ? "mesh.stl" : "mesh.obj";
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    const knap::TriangleMesh mesh = knap::ReadMesh(name, bytes, 0.001);
    Require(!mesh.triangles.empty(), "a mesh has triangles");
    const int count = static_cast<int>(mesh.vertices.size());
    for (const Eigen::Vector3i& t : mesh.triangles) {
      Require(t.minCoeff() >= 0 && t.maxCoeff() < count, "triangles name vertices of the mesh");
      Require(t[0] != t[1] && t[1] != t[2] && t[2] != t[0], "triangles have three corners");
    }
    const knap::MeshDefects defects = knap::FindDefects(mesh);
    Require(defects.bad_indices == 0 && defects.non_finite_vertices == 0, "a mesh is finite");
    Require(!defects.empty() || knap::CalcSignedVolume(mesh) > 0.0, "a body has a volume");
    Require(defects.empty() == defects.Describe().empty(), "defects have names");
  } catch (const std::runtime_error& error) {
    const std::string what = error.what();
    Require(what.rfind(name + ":", 0) == 0 && what.find('\n') == std::string::npos, "one line that names the file");
  }
  return 0;
}
