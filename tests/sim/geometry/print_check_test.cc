// What a printer would say of bodies whose faults are known, and what files hold of a mesh.
#include "sim/geometry/print_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "sim/geometry/mesh_io.h"
#include "sim/geometry/print_file.h"

namespace knap {
namespace print_check_test {

using Eigen::Vector3d;
using Eigen::Vector3i;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A prism over an outline in the x-z plane, seen from −y counter-clockwise and fanned from its first corner, from y = 0
// to `depth`; millimetres.
TriangleMesh MakePrism(const std::vector<std::array<double, 2>>& outline, double depth,
                       const std::vector<Vector3i>& cap) {
  TriangleMesh mesh;
  const int n = static_cast<int>(outline.size());
  for (const double y : {0.0, depth}) {
    for (const auto& [x, z] : outline) mesh.vertices.emplace_back(1e-3 * x, 1e-3 * y, 1e-3 * z);
  }
  for (const Vector3i& t : cap) {
    mesh.triangles.push_back(t);
    mesh.triangles.emplace_back(n + t[0], n + t[2], n + t[1]);
  }
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    mesh.triangles.emplace_back(i, n + i, n + next);
    mesh.triangles.emplace_back(i, n + next, next);
  }
  return mesh;
}

TriangleMesh MakeBox(double x, double y, double z) {
  return MakePrism({{0, 0}, {x, 0}, {x, z}, {0, z}}, y, {{0, 1, 2}, {0, 2, 3}});
}

const PrintFinding* Find(const PrintCheck& check, const std::string& kind) {
  for (const PrintFinding& finding : check.findings) {
    if (finding.kind == kind) return &finding;
  }
  return nullptr;
}

TEST(PrintCheck, FindsNothingInABlock) {
  const PrintCheck check = CheckPrint(MakeBox(30, 20, 10), {});
  EXPECT_THAT(check.findings, IsEmpty());
  EXPECT_NEAR(check.volume, 6000e-9, 1e-18);
  ASSERT_TRUE(check.wall.has_value());
  EXPECT_NEAR(check.wall->width, 0.010, 1e-12);
  EXPECT_FALSE(check.gap.has_value());
}

TEST(PrintCheck, TellsAThinWallWithItsPlace) {
  // A foot of 10 mm with a fin of 0.3 mm.
  const TriangleMesh mesh = MakePrism({{0, 0}, {10, 0}, {10, 5}, {5.3, 5}, {5.3, 15}, {5, 15}, {5, 5}, {0, 5}}, 12,
                                      {{0, 1, 7}, {1, 6, 7}, {1, 3, 6}, {1, 2, 3}, {3, 4, 5}, {3, 5, 6}});
  ASSERT_EQ(FindDefects(mesh).Describe(), "");
  const PrintCheck check = CheckPrint(mesh, {});
  ASSERT_EQ(check.findings.size(), 1u);
  const PrintFinding& finding = check.findings[0];
  EXPECT_EQ(finding.kind, "wall");
  EXPECT_FALSE(finding.is_error);
  EXPECT_THAT(finding.text, HasSubstr("a wall is 0.3 mm across, less than the nozzle's 0.4 mm"));
  ASSERT_TRUE(finding.place.has_value());
  EXPECT_GT(finding.place->z(), 0.005);
  EXPECT_LT(finding.place->z(), 0.015);
  // Both sides of the fin, 2 · 10 · 12 mm², of all.
  const double surface = 2.0 * (10 * 5 + 0.3 * 10) + 12.0 * (10 + 2 * 5 + 9.7 + 0.3 + 20);
  EXPECT_NEAR(check.wall->share, 240.0 / surface, 1e-3);
  EXPECT_THAT(CheckPrint(mesh, {.nozzle = 0.25e-3}).findings, IsEmpty());
}

TEST(PrintCheck, TellsANarrowGap) {
  const TriangleMesh mesh = MakePrism({{0, 0}, {10, 0}, {10, 8}, {5.2, 8}, {5.2, 3}, {5, 3}, {5, 8}, {0, 8}}, 12,
                                      {{0, 5, 6}, {0, 6, 7}, {0, 4, 5}, {0, 1, 4}, {1, 2, 3}, {1, 3, 4}});
  ASSERT_EQ(FindDefects(mesh).Describe(), "");
  const PrintCheck check = CheckPrint(mesh, {});
  ASSERT_EQ(check.findings.size(), 1u);
  EXPECT_EQ(check.findings[0].kind, "gap");
  EXPECT_NEAR(check.gap->width, 0.2e-3, 1e-9);
  EXPECT_NEAR(check.gap->place.x(), 5.1e-3, 0.11e-3);
}

TEST(PrintCheck, TellsWhatTheBedIsTooSmallFor) {
  EXPECT_THAT(CheckPrint(MakeBox(205, 245, 10), {}).findings, IsEmpty()) << "turned by 90 degrees it fits";
  const PrintCheck lying = CheckPrint(MakeBox(20, 20, 240), {});
  ASSERT_NE(Find(lying, "size"), nullptr);
  EXPECT_THAT(Find(lying, "size")->text, HasSubstr("lying on another side they do"));
  const PrintCheck never = CheckPrint(MakeBox(20, 20, 300), {});
  ASSERT_NE(Find(never, "size"), nullptr);
  EXPECT_EQ(Find(never, "size")->text, "20 x 20 x 300 mm do not fit on the bed, 250 x 210 x 210 mm");
}

TEST(PrintCheck, TellsWhatHangsOver) {
  // A wall that leans by 30 degrees stands, one by 60 does not, and a ceiling least of all.
  const auto lean = [](double across) {
    return MakePrism({{0, 0}, {10, 0}, {10 + across, 10}, {across, 10}}, 10, {{0, 1, 2}, {0, 2, 3}});
  };
  EXPECT_THAT(CheckPrint(lean(5.77), {}).findings, IsEmpty());
  EXPECT_THAT(CheckPrint(lean(10.0), {}).findings, IsEmpty()) << "45 degrees are allowed";
  const PrintCheck steep = CheckPrint(lean(17.32), {});
  ASSERT_NE(Find(steep, "overhang"), nullptr);
  EXPECT_NEAR(steep.steepest, 60.0 * M_PI / 180.0, 1e-4);
  EXPECT_NEAR(steep.overhang, 200.0 / (2 * 100 + 2 * 200 + 2 * 100), 1e-4);
  EXPECT_NEAR(Find(steep, "overhang")->place->z(), 5e-3, 2e-3);
  const TriangleMesh arch = MakePrism({{0, 0}, {3, 0}, {3, 5}, {7, 5}, {7, 0}, {10, 0}, {10, 8}, {0, 8}}, 10,
                                      {{0, 1, 2}, {0, 2, 7}, {2, 3, 6}, {2, 6, 7}, {3, 4, 5}, {3, 5, 6}});
  ASSERT_EQ(FindDefects(arch).Describe(), "");
  const PrintCheck ceiling = CheckPrint(arch, {});
  ASSERT_NE(Find(ceiling, "overhang"), nullptr);
  EXPECT_NEAR(ceiling.steepest, M_PI / 2, 1e-12);
  EXPECT_NEAR(Find(ceiling, "overhang")->place->z(), 5e-3, 1e-12);
}

TEST(PrintCheck, RefusesWhatIsNoBodyWithThePlace) {
  TriangleMesh open = MakeBox(10, 10, 10);
  open.triangles.pop_back();
  const PrintCheck check = CheckPrint(open, {});
  ASSERT_TRUE(check.HasErrors());
  ASSERT_EQ(check.findings.size(), 1u);
  EXPECT_THAT(check.findings[0].text, HasSubstr("3 open edges"));
  ASSERT_TRUE(check.findings[0].place.has_value());
  EXPECT_LE(check.findings[0].place->norm(), 0.0174);

  TriangleMesh inverted = MakeBox(10, 10, 10);
  for (Vector3i& t : inverted.triangles) std::swap(t[0], t[1]);
  EXPECT_TRUE(CheckPrint(inverted, {}).HasErrors());

  // One corner pushed through the opposite side.
  TriangleMesh crossed = MakeBox(10, 10, 10);
  for (Vector3d& v : crossed.vertices) {
    if (v.norm() < 1e-9) v = Vector3d(0.020, 0.003, 0.004);
  }
  const PrintCheck crossing = CheckPrint(crossed, {});
  ASSERT_TRUE(crossing.HasErrors());
  EXPECT_THAT(crossing.findings[0].text, HasSubstr("parts that cross or touch"));
  EXPECT_TRUE(crossing.findings[0].place.has_value());

  EXPECT_TRUE(CheckPrint({}, {}).HasErrors());
}

// ---- Files ----------------------------------------------------------------------------------------------------------

TEST(PrintFile, FormatsAreKnownByName) {
  for (const char* name : {"stl", "3mf", "obj", "glb"}) {
    const auto format = FindPrintFormat(name);
    ASSERT_TRUE(format.has_value());
    EXPECT_EQ(GetName(*format), name);
  }
  EXPECT_FALSE(FindPrintFormat("STL").has_value());
}

TEST(PrintFile, ObjAndStlReadBackAsRounded) {
  TriangleMesh mesh = MakeBox(33.3333333333, 12.1234567891, 7.77777777777);
  for (const PrintFormat format : {PrintFormat::kStl, PrintFormat::kObj}) {
    const TriangleMesh rounded = RoundAsWritten(mesh, format);
    const std::string name = format == PrintFormat::kStl ? "tool.stl" : "tool.obj";
    const TriangleMesh back = ReadMesh(name, WritePrintFile(mesh, format, "tool"), 1e-3);
    ASSERT_EQ(back.triangles.size(), mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const Vector3d& a = back.vertices[back.triangles[i][k]];
        const Vector3d& b = rounded.vertices[rounded.triangles[i][k]];
        // A text has nine digits, which give the same single number again.
        EXPECT_EQ((1e3 * a).cast<float>(), (1e3 * b).cast<float>()) << GetName(format);
      }
    }
    EXPECT_GT((rounded.vertices[2] - mesh.vertices[2]).norm(), 1e-12);
  }
}

TEST(PrintFile, A3mfSaysItsUnitAndHoldsTheMesh) {
  const TriangleMesh mesh = MakeBox(33.3333333333, 12.1234567891, 7.77777777777);
  const std::string file = WritePrintFile(mesh, PrintFormat::k3mf, "a<b");
  EXPECT_EQ(file, WritePrintFile(mesh, PrintFormat::k3mf, "a<b"));
  EXPECT_EQ(file.substr(0, 4), "PK\x03\x04");
  EXPECT_THAT(file, HasSubstr("<model unit=\"millimeter\""));
  EXPECT_THAT(file, HasSubstr("name=\"a&lt;b\""));
  EXPECT_THAT(file, HasSubstr("_rels/.rels"));
  const TriangleMesh rounded = RoundAsWritten(mesh, PrintFormat::k3mf);
  std::size_t at = 0;
  for (const Vector3d& v : rounded.vertices) {
    at = file.find("<vertex x=\"", at + 1);
    ASSERT_NE(at, std::string::npos);
    float x = 0, y = 0, z = 0;
    ASSERT_EQ(std::sscanf(file.c_str() + at, "<vertex x=\"%f\" y=\"%f\" z=\"%f\"/>", &x, &y, &z), 3);
    EXPECT_EQ(1e3 * v.x(), double{x});
    EXPECT_NEAR(1e3 * v.y(), double{y}, 1e-14);
    EXPECT_NEAR(1e3 * v.z(), double{z}, 1e-14);
  }
  EXPECT_EQ(file.find("<vertex x=\"", at + 1), std::string::npos);
}

TEST(PrintFile, AGlbIsInMetresWithYUp) {
  const std::string file = WritePrintFile(MakeBox(30, 20, 10), PrintFormat::kGlb, "tool");
  std::array<std::uint32_t, 5> head;
  std::memcpy(head.data(), file.data(), sizeof head);
  EXPECT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(head[1], 2u);
  EXPECT_EQ(head[2], file.size());
  const auto json = nlohmann::json::parse(file.substr(20, head[3]));
  const auto& position =
      json.at("accessors").at(json.at("meshes")[0]["primitives"][0]["attributes"]["POSITION"].get<std::size_t>());
  EXPECT_EQ(position.at("count"), 8);
  EXPECT_NEAR(position.at("max")[0].get<double>(), 0.030, 1e-8);
  EXPECT_NEAR(position.at("max")[2].get<double>(), 0.010, 1e-8);
  // Columns: x stays, y goes to −z, z to y.
  const std::vector<double> matrix = json.at("nodes")[0].at("matrix");
  EXPECT_EQ(matrix, (std::vector<double>{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}));
}

TEST(PrintFile, RefusesWhatIsInsideOut) {
  TriangleMesh box = MakeBox(1, 1, 1);
  for (Vector3d& v : box.vertices) v.x() = -v.x();
  for (const PrintFormat format : {PrintFormat::kStl, PrintFormat::k3mf, PrintFormat::kObj, PrintFormat::kGlb}) {
    EXPECT_THROW(WritePrintFile(box, format, "box"), std::runtime_error);
  }
}

}  // namespace print_check_test
}  // namespace knap
