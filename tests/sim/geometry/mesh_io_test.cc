#include "sim/geometry/mesh_io.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <stdexcept>

#include "tests/sim/geometry/read_error.h"

namespace knap {
namespace mesh_io_test {

using Eigen::Vector3d;
using Eigen::Vector3i;
using test::ReadError;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

// A box 2 x 3 x 5 from the origin, of quadrangles, its vertices in an order no face would give.
const char kBoxObj[] = R"(# a box
mtllib /etc/hostname
o box
v 2 3 5
v 0 0 0
v 2.0 0 0
v 0 3e0 5
v +2 3 0 # behind a number
v 0 3 0
v 0 0 5 0.1 0.2 0.3
v 2 0 5
vn 0 0 -1
vt 0 0
usemtl red
s off
f 2//1 6//1 5//1 3//1
f 7/1 8/1 1/1 4/1
f 2 3 8 7
f -3 -5 -8 -4
f 2 7 4 6
f 3 5 1 8
)";

TEST(ReadObj, KeepsTheOrderOfVertices) {
  const TriangleMesh mesh = ReadMesh("box.obj", kBoxObj, 1);
  const std::vector<Vector3d> expected = {{2, 3, 5}, {0, 0, 0}, {2, 0, 0}, {0, 3, 5},
                                          {2, 3, 0}, {0, 3, 0}, {0, 0, 5}, {2, 0, 5}};
  EXPECT_EQ(mesh.vertices, expected);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(FindDefects(mesh).Describe(), "");
  EXPECT_DOUBLE_EQ(CalcSignedVolume(mesh), 30);
}

TEST(ReadObj, KeepsTheOrderOfThePushersCage) {
  const std::string file = std::string(KNAP_CONFIGS) + "/meshes/pusher_cage.obj";
  const TriangleMesh cage = ReadMesh(file, ReadBytes(file), 0.001);
  ASSERT_EQ(cage.vertices.size(), 24u);
  EXPECT_EQ(FindDefects(cage).Describe(), "");
  const std::array<double, 6> stations = {-53, -37, -22, 22, 37, 53};
  for (size_t s = 0; s < stations.size(); ++s) {
    const std::array<Vector3d, 4> expected = {Vector3d(stations[s], -13, -1), Vector3d(stations[s], 1, -1),
                                              Vector3d(stations[s], 1, 21), Vector3d(stations[s], -13, 21)};
    for (size_t k = 0; k < 4; ++k) EXPECT_EQ(cage.vertices[4 * s + k], 0.001 * expected[k]) << s << " " << k;
  }
}

TEST(ReadObj, KeepsAllDigits) {
  const TriangleMesh mesh = ReadMesh("t.obj", "v 0.1234567890123456 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 1);
  EXPECT_EQ(mesh.vertices[0].x(), 0.1234567890123456);
}

TEST(ReadObj, WeldsEqualVerticesAndDropsTrianglesThatVanish) {
  const TriangleMesh mesh = ReadMesh("t.obj",
                                     "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -0 0 0\nv 0 0 1\n"
                                     "f 1 3 2\nf 4 2 5\nf 4 5 3\nf 2 3 5\nf 1 4 5\n",
                                     1);
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(FindDefects(mesh).Describe(), "");
}

TEST(ReadObj, SplitsConcavePolygonsWithinTheirOutline) {
  // An arrow head with its notch at vertex 4: a fan from vertex 1 would cover 1.5 times its area.
  const TriangleMesh mesh = ReadMesh("arrow.obj", "v -1 -1 0\nv 1 0 0\nv -1 1 0\nv 0 0 0\nf 3 4 1 2\n", 1);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  double area = 0;
  for (const Vector3i& t : mesh.triangles) {
    const Vector3d& a = mesh.vertices[t[0]];
    const Vector3d n = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    EXPECT_GT(n.z(), 0);
    area += n.norm() / 2;
  }
  EXPECT_DOUBLE_EQ(area, 1);
}

TEST(ReadObj, SplitsLargePolygons) {
  std::string text;
  const int corners = 2000;  // the line of the face is longer than assimp's line buffer
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * M_PI * i / corners;
    text += fmt::format("v {} {} 0\n", std::cos(angle), std::sin(angle));
  }
  text += 'f';
  for (int i = 1; i <= corners; ++i) text += fmt::format(" {}", i);
  EXPECT_EQ(ReadMesh("disc.obj", text, 1).triangles.size(), 1998u);
}

TEST(ReadObj, ErrorsNameLineAndColumn) {
  EXPECT_EQ(ReadError("dir/cage.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
            "dir/cage.obj:4:7: vertex 9 does not exist: the file has 3, counted from 1");
  EXPECT_EQ(ReadError("c.obj", "v 0 0 0\nv 1 0 0\n  f 1 2\n"), "c.obj:3:8: a face needs at least three vertices");
  EXPECT_EQ(ReadError("c.obj", "v 0 x 0\n"), "c.obj:1:5: 'x' is not a number within +-1e9");
  EXPECT_EQ(ReadError("c.obj", "v 0 nan 0\n"), "c.obj:1:5: 'nan' is not a number within +-1e9");
  EXPECT_EQ(ReadError("c.obj", "v 0 0\n"), "c.obj:1:6: a number is missing");
  EXPECT_EQ(ReadError("c.obj", "\n\nhello\n"), "c.obj:3:1: unknown OBJ keyword 'hello'");
  EXPECT_EQ(ReadError("c.obj", "v 0 0 0\nf 0 1 1\n"),
            "c.obj:2:3: vertex 0 does not exist: the file has 1, counted from 1");
  EXPECT_EQ(ReadError("c.obj", ""), "c.obj: no triangles in the file");
  EXPECT_EQ(ReadError("c.obj", "v 0 0 0\n"), "c.obj: no triangles in the file");
}

TEST(ReadMesh, RefusesOtherFormatsAndUnits) {
  EXPECT_EQ(ReadError("part.PLY", "ply\n"), "part.PLY: cannot read '.ply' files as meshes; save it as .obj or .stl");
  EXPECT_EQ(ReadError("part", "ply\n"), "part: cannot read '' files as meshes; save it as .obj or .stl");
  for (const double unit : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THAT(ReadError("box.obj", kBoxObj, unit), HasSubstr("must be positive and finite"));
  }
}

TEST(ReadMesh, ScalesToMetres) {
  const TriangleMesh mesh = ReadMesh("BOX.OBJ", kBoxObj, 0.001);
  EXPECT_EQ(CalcBoundingBox(mesh).max(), 0.001 * Vector3d(2, 3, 5));
}

std::string MakeTextStl() {
  const TriangleMesh mesh = ReadMesh("box.obj", kBoxObj, 1);
  std::string text = "solid a box\n";
  for (const Vector3i& t : mesh.triangles) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (int k = 0; k < 3; ++k) {
      const Vector3d& v = mesh.vertices[t[k]];
      text += fmt::format("      vertex {} {} {}\n", v.x(), v.y(), v.z());
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid a box\n";
}

TEST(ReadStl, ReadsText) {
  const TriangleMesh mesh = ReadMesh("box.stl", MakeTextStl(), 1);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_EQ(FindDefects(mesh).Describe(), "");
  EXPECT_DOUBLE_EQ(CalcSignedVolume(mesh), 30);
}

TEST(ReadStl, ReadsABinaryFileThatLooksLikeText) {
  std::string stl = WriteStl(ReadMesh("box.obj", kBoxObj, 1));
  std::memcpy(stl.data(), "solid COLOR=abcd", 16);
  EXPECT_NEAR(CalcSignedVolume(ReadMesh("box.stl", stl, 0.001)), 30, 1e-4);
}

TEST(ReadStl, ErrorsNameTheFile) {
  EXPECT_EQ(ReadError("b.stl", ""), "b.stl: neither a text STL nor a complete binary one (0 bytes)");
  EXPECT_EQ(ReadError("b.stl", std::string(84, '\0')), "b.stl: no triangles in the file");
  EXPECT_EQ(ReadError("b.stl", "solid x\nendsolid x\n"), "b.stl: no triangles in the file");
  EXPECT_EQ(ReadError("b.stl", "solid x\nfacet normal 0 0 1\n outer lop\n"), "b.stl:3:8: expected 'loop', found 'lop'");
  std::string stl = WriteStl(ReadMesh("box.obj", kBoxObj, 1));
  const float infinity = HUGE_VALF;
  std::memcpy(stl.data() + 84 + 3 * 50 + 12, &infinity, 4);  // the first corner of facet 3
  EXPECT_EQ(ReadError("b.stl", stl), "b.stl: facet 3 has a corner that is not finite");
}

// Assimp aborts the process on some damaged files; none of ours may get that far.
TEST(ReadMesh, SurvivesTruncatedAndDamagedFiles) {
  const std::string binary = WriteStl(ReadMesh("box.obj", kBoxObj, 1));
  const std::vector<std::pair<std::string, std::string>> files = {
      {"b.obj", kBoxObj}, {"b.stl", binary}, {"b.stl", MakeTextStl()}};
  std::mt19937 random(1);
  int refused = 0, accepted = 0;
  const auto read = [&](const std::string& name, const std::string& bytes) {
    const std::string error = ReadError(name, bytes);
    if (error.empty()) {
      ++accepted;
      return;
    }
    ++refused;
    EXPECT_THAT(error, StartsWith(name + ":"));
    EXPECT_EQ(error.find_first_of("\r\n"), std::string::npos) << error;
  };
  for (const auto& [name, whole] : files) {
    for (size_t size = 0; size < whole.size(); ++size) read(name, whole.substr(0, size));
    for (int i = 0; i < 1000; ++i) {
      std::string damaged = whole;
      for (unsigned n = 1 + random() % 3; n > 0; --n) {
        static constexpr char kTypical[] = "0123456789-/ \n.eEfvp\\";
        const bool typical = random() % 2 == 0;
        damaged[random() % damaged.size()] = typical ? kTypical[random() % 21] : static_cast<char>(random() % 256);
      }
      read(name, damaged);
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(accepted, 500);
}

TEST(ReadStl, RefusesEveryTruncation) {
  const std::string binary = WriteStl(ReadMesh("box.obj", kBoxObj, 1));
  for (size_t size = 0; size < binary.size(); ++size) {
    EXPECT_NE(ReadError("b.stl", binary.substr(0, size)), "") << size;
  }
}

// The pusher's bar: 104 x 12 x 20 mm.
TEST(WriteStl, IsWatertightWithTheRightVolumeInMillimetres) {
  const std::string file = std::string(KNAP_CONFIGS) + "/meshes/pusher.obj";
  const TriangleMesh pusher = ReadMesh(file, ReadBytes(file), 0.001);
  EXPECT_EQ(pusher.vertices.size(), 55u * 3u * 3u - 53u);  // all but the inner ones of 54 x 2 x 2 cells
  ASSERT_EQ(FindDefects(pusher).Describe(), "");

  const TriangleMesh back = ReadMesh("pusher.stl", WriteStl(pusher), 1);
  EXPECT_EQ(FindDefects(back).Describe(), "");
  EXPECT_EQ(back.vertices.size(), pusher.vertices.size());
  EXPECT_EQ(back.triangles.size(), pusher.triangles.size());
  EXPECT_NEAR(CalcSignedVolume(back), 104 * 12 * 20, 104 * 12 * 20 * 1e-6);  // single precision
  EXPECT_TRUE(CalcBoundingBox(back).isApprox(Eigen::AlignedBox3d(Vector3d(-52, -12, 0), Vector3d(52, 0, 20)), 1e-6));
}

TEST(WriteStl, RefusesWhatIsInsideOut) {
  TriangleMesh box = ReadMesh("box.obj", kBoxObj, 1);
  for (Vector3d& v : box.vertices) v.x() = -v.x();
  EXPECT_THROW(WriteStl(box), std::runtime_error);
  EXPECT_THROW(WriteStl({}), std::runtime_error);
}

TEST(WriteStl, HasUnitNormalsThatPointOutwards) {
  const std::string stl = WriteStl(ReadMesh("box.obj", kBoxObj, 1));
  ASSERT_EQ(stl.size(), 84u + 12 * 50);
  EXPECT_NE(stl.substr(0, 5), "solid");  // readers would take it for text
  std::uint32_t count = 0;
  std::memcpy(&count, stl.data() + 80, 4);
  EXPECT_EQ(count, 12u);
  std::set<std::array<float, 3>> normals;
  for (size_t i = 0; i < 12; ++i) {
    std::array<std::array<float, 3>, 4> facet;
    std::memcpy(&facet, stl.data() + 84 + 50 * i, sizeof facet);
    const Eigen::Vector3f normal(facet[0].data());
    const Eigen::Vector3f corner(facet[1].data());
    EXPECT_NEAR(normal.norm(), 1, 1e-6);
    EXPECT_GT(normal.dot(corner - Eigen::Vector3f(1000, 1500, 2500)), 900);
    normals.insert({normal.x() + 0, normal.y() + 0, normal.z() + 0});
  }
  EXPECT_EQ(normals.size(), 6u);
}

TEST(WriteObj, ReadsBack) {
  const TriangleMesh box = ReadMesh("box.obj", kBoxObj, 0.001);
  const TriangleMesh back = ReadMesh("back.obj", WriteObj(box, 0.001), 0.001);
  EXPECT_EQ(FindDefects(back).Describe(), "");
  EXPECT_EQ(back.vertices.size(), 8u);
  EXPECT_NEAR(CalcSignedVolume(back), 30e-9, 30e-9 * 1e-6);
}

// Groups of a cage name vertices by their numbers: those must be the file's, whatever triangle meets them first.
TEST(WriteObj, KeepsTheNumbersOfVerticesAndTriangles) {
  TriangleMesh mesh = ReadMesh("box.obj", kBoxObj, 0.001);
  std::reverse(mesh.vertices.begin(), mesh.vertices.end());
  mesh.vertices.emplace_back(0.1, 0.2, 0.3);  // no triangle uses it
  for (Vector3i& t : mesh.triangles) t = Vector3i::Constant(7) - t;
  const TriangleMesh back = ReadMesh("back.obj", WriteObj(mesh, 0.001), 0.001);
  ASSERT_EQ(back.vertices.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    EXPECT_TRUE(back.vertices[i].isApprox(mesh.vertices[i], 1e-8)) << i;
  }
  EXPECT_EQ(back.triangles, mesh.triangles);
}

TEST(WriteFile, WritesBytesAndSaysWhyNot) {
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) / "knap_mesh_io_test.bin";
  const std::string bytes("a\0b\r\n", 5);
  WriteFile(path, bytes);
  EXPECT_EQ(ReadBytes(path), bytes);
  std::filesystem::remove(path);
  try {
    WriteFile("/nonexistent/tool.stl", bytes);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "cannot write /nonexistent/tool.stl: No such file or directory");
  }
}

}  // namespace mesh_io_test
}  // namespace knap
