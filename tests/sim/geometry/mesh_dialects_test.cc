// Every legal way to write a mesh gives the bits of the plain one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <regex>
#include <string>

#include "sim/geometry/mesh_io.h"
#include "tests/sim/geometry/read_error.h"

namespace knap {
namespace mesh_dialects_test {

using test::ReadError;
using ::testing::HasSubstr;

const std::string kMark = "\xef\xbb\xbf";

const std::string kObj =
    "v 0.1 0 0\n"
    "v 1.25 0 0\n"
    "v 0 1e0 0\n"
    "v 0 0 -1\n"
    "f 1 2 3\n"
    "f 1 4 2\n"
    "f 1 3 4\n"
    "f 2 4 3\n";

const std::string kStl =
    "solid a thing\n"
    "facet normal 0 0 1\n outer loop\n  vertex 0.1 0 0\n  vertex 1.25 0 0\n  vertex 0 1 0\n endloop\nendfacet\n"
    "facet normal 0 0 1\n outer loop\n  vertex 0.1 0 0\n  vertex 0 0 -1\n  vertex 1.25 0 0\n endloop\nendfacet\n"
    "facet normal 0 0 1\n outer loop\n  vertex 0.1 0 0\n  vertex 0 1 0\n  vertex 0 0 -1\n endloop\nendfacet\n"
    "facet normal 0 0 1\n outer loop\n  vertex 1.25 0 0\n  vertex 0 0 -1\n  vertex 0 1 0\n endloop\nendfacet\n"
    "endsolid a thing\n";

std::string Replace(const std::string& text, const std::string& what, const std::string& by) {
  std::string result = std::regex_replace(text, std::regex(what), by);
  EXPECT_NE(result, text);
  return result;
}

void ExpectSame(const std::string& name, const std::string& plain, const std::string& dialect) {
  const TriangleMesh a = ReadMesh(name, plain, 0.001);
  const TriangleMesh b = ReadMesh(name, dialect, 0.001);
  EXPECT_EQ(FindDefects(a).Describe(), "");
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles, b.triangles);
}

TEST(ObjDialects, AByteOrderMark) { ExpectSame("t.obj", kObj, kMark + kObj); }

TEST(ObjDialects, LineEnds) {
  ExpectSame("t.obj", kObj, Replace(kObj, "\n", "\r"));
  ExpectSame("t.obj", kObj, Replace(kObj, "\n", "\r\n"));
  ExpectSame("t.obj", kObj, kObj.substr(0, kObj.size() - 1));
}

TEST(ObjDialects, Continuations) {
  ExpectSame("t.obj", kObj, Replace(kObj, " ", " \\\n "));
  ExpectSame("t.obj", kObj, Replace(kObj, " ", "\\\r\n "));
  ExpectSame("t.obj", kObj, Replace(kObj, "\nf 1 2 3\n", "\ng a\\\nb \\\n f\nf 1 2\\\n 3\n"));
  ExpectSame("t.obj", kObj, kObj + "l 1 2 \\");
}

TEST(ObjDialects, ACommentEndsWithItsLine) { ExpectSame("t.obj", kObj, "# C:\\meshes\\\n" + kObj); }

TEST(ObjDialects, StatementsThatDoNotConcernPolygons) {
  ExpectSame("t.obj", kObj,
             "lod 3\nbevel on\nc_interp off\nd_interp off\nmg 1 0.5\ng a\no b\ns 1\nusemtl c\nmtllib d.mtl\nmaplib e\n"
             "usemap off\nshadow_obj f\ntrace_obj g\nvt 0 0\nvn 0 0 1\nvp 0 0\ncstype bezier\ndeg 3\n" +
                 kObj + "curv 0 1 1 2\nparm u 0 1\nend\np 1\nl 1 2\n");
}

TEST(ObjDialects, FacesBeforeTheirVertices) {
  const std::size_t faces = kObj.find('f');
  ExpectSame("t.obj", kObj, kObj.substr(faces) + kObj.substr(0, faces));
  ExpectSame("t.obj", kObj, Replace(kObj, "f 2 4 3", "f -3 -1 -2"));
  EXPECT_EQ(ReadError("t.obj", "f -1 -2 -3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"),
            "t.obj:1:3: vertex -1 does not exist: the file has 0 up to here");
}

TEST(ObjDialects, NumbersTooSmallForADoubleAreZero) {
  ExpectSame("t.obj", kObj, Replace(kObj, "0 0 -1", "1e-400 -1e-999 -1"));
  EXPECT_THAT(ReadError("t.obj", Replace(kObj, "0 0 -1", "0 0 1e400")), HasSubstr("not a number within"));
}

TEST(ObjDialects, WhatWouldBeMissingIsRefused) {
  EXPECT_EQ(ReadError("t.obj", kObj + "surf 0 1 0 1 1 2 3 4\n"),
            "t.obj:9:1: 'surf' is a free-form surface; save the surface as polygons in one file");
  EXPECT_THAT(ReadError("t.obj", kObj + "call other.obj\n"), HasSubstr("a reference to another file"));
}

TEST(StlDialects, Capitals) {
  std::string capitals = kStl;
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  ExpectSame("t.stl", kStl, capitals);
}

TEST(StlDialects, AMarkOrBlanksBeforeIt) {
  ExpectSame("t.stl", kStl, kMark + kStl);
  ExpectSame("t.stl", kStl, " \t\n" + kStl);
  ExpectSame("t.stl", kStl, kMark + "\r\n  " + kStl);
}

TEST(StlDialects, LineEndsAndLines) {
  ExpectSame("t.stl", kStl, Replace(kStl, "\n", "\r"));
  ExpectSame("t.stl", kStl, Replace(kStl, "\n", "\r\n"));
  ExpectSame("t.stl", kStl, Replace(kStl, "\n +", " "));
  ExpectSame("t.stl", kStl, Replace(kStl, "vertex ", "vertex\n"));
}

TEST(StlDialects, BytesBehindItsEnd) {
  ExpectSame("t.stl", kStl, kStl + "\n\x1a");
  ExpectSame("t.stl", kStl, kStl + std::string(3, '\0') + "written by a program");
  const std::string binary = WriteStl(ReadMesh("t.stl", kStl, 0.001));
  ExpectSame("t.stl", binary, binary + "more");
  std::string named = binary;
  std::memcpy(named.data(), "solid thing", 11);
  ExpectSame("t.stl", binary, named + std::string(50, 'x'));
}

TEST(StlDialects, SeveralSolidsAndNormalsThatAreNoNumbers) {
  ExpectSame("t.stl", kStl, Replace(kStl, "normal 0 0 1", "normal nan -nan(ind) 1.#QNAN"));
  const std::size_t second = kStl.find("facet normal", 20);
  ExpectSame("t.stl", kStl, kStl.substr(0, second) + "endsolid\nsolid b\n" + kStl.substr(second));
}

}  // namespace mesh_dialects_test
}  // namespace knap
