#include "sim/geometry/mesh_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <system_error>
#include <utility>

#include "sim/geometry/word_reader.h"

namespace knap {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMaxVertices = std::size_t{1} << 24;
constexpr std::size_t kMaxCorners = 10'000;  // splitting a polygon takes the square of it

// Legal statements that do not concern a surface of polygons [Wavefront 1995, App. B1].
constexpr std::array<std::string_view, 32> kIgnored = {
    "vt",       "vn",    "vp",    "g",          "o",         "s",      "mg",     "l",
    "p",        "lod",   "bevel", "usemtl",     "mtllib",    "usemap", "maplib", "c_interp",
    "d_interp", "ctech", "stech", "shadow_obj", "trace_obj", "cstype", "deg",    "bmat",
    "step",     "curv",  "curv2", "parm",       "trim",      "hole",   "scrv",   "sp"};

// What would be missing if it were passed over.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kRefused = {
    {{"surf", "a free-form surface"},
     {"bzp", "a free-form surface"},
     {"bsp", "a free-form surface"},
     {"cdc", "a free-form curve"},
     {"cdp", "a free-form surface"},
     {"res", "a free-form surface"},
     {"call", "a reference to another file"},
     {"csh", "a command"}}};

// Vertices of the whole file, and how many came before the line that is being read.
struct VertexCount {
  long long total = 0;
  long long before = 0;
};

// One corner of a face, "7", "7/1", "7//2", "7/1/2" or counted back from the last vertex before it, "-1".
int ParseCorner(const WordReader& reader, std::string_view word, const VertexCount& count) {
  const std::string_view digits = word.substr(0, word.find('/'));
  long long number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    reader.Fail(fmt::format("'{}' is not a vertex number", WordReader::Shorten(word)));
  }
  if (number < -count.before) {
    reader.Fail(fmt::format("vertex {} does not exist: the file has {} up to here", number, count.before));
  }
  if (number == 0 || number > count.total) {
    reader.Fail(fmt::format("vertex {} does not exist: the file has {}, counted from 1", number, count.total));
  }
  return static_cast<int>(number < 0 ? count.before + number : number - 1);
}

ObjPolygon ParseFace(WordReader* reader, const VertexCount& count) {
  ObjPolygon polygon{reader->line_number(), {}};
  for (std::string_view word = reader->NextWord(); !word.empty(); word = reader->NextWord()) {
    polygon.corners.push_back(ParseCorner(*reader, word, count));
    if (polygon.corners.size() > kMaxCorners) {
      reader->Fail(fmt::format("a face of more than {} vertices", kMaxCorners));
    }
  }
  if (polygon.corners.size() < 3) reader->Fail("a face needs at least three vertices");
  return polygon;
}

void CheckKeyword(const WordReader& reader, std::string_view keyword) {
  if (std::find(kIgnored.begin(), kIgnored.end(), keyword) != kIgnored.end() || keyword == "end" || keyword == "con") {
    return;
  }
  for (const auto& [refused, meaning] : kRefused) {
    if (keyword != refused) continue;
    reader.Fail(fmt::format("'{}' is {}; save the surface as polygons in one file", keyword, meaning));
  }
  reader.Fail(fmt::format("unknown OBJ keyword '{}'", WordReader::Shorten(keyword)));
}

// Requires the next words to be these, in capitals or not.
void Expect(WordReader* reader, std::initializer_list<std::string_view> words) {
  for (const std::string_view expected : words) {
    const std::string_view word = reader->NextWordOfAnyLine();
    if (word.empty()) reader->Fail(fmt::format("the file ends where '{}' is expected", expected));
    if (ToLowerCase(word) != expected) {
      reader->Fail(fmt::format("expected '{}', found '{}'", expected, WordReader::Shorten(word)));
    }
  }
}

void ParseFacet(WordReader* reader, TriangleMesh* mesh) {
  Expect(reader, {"normal"});
  // The corners say where outside is; of triangles without area some programs write "nan" here.
  for (int k = 0; k < 3; ++k) {
    const std::string_view word = reader->NextWordOfAnyLine();
    if (word.empty() || ToLowerCase(word) == "outer") reader->Fail("a number is missing");
  }
  Expect(reader, {"outer", "loop"});
  const int first = static_cast<int>(mesh->vertices.size());
  for (int corner = 0; corner < 3; ++corner) {
    Expect(reader, {"vertex"});
    Vector3d v;
    for (int k = 0; k < 3; ++k) v[k] = reader->ParseCoordinate(reader->NextWordOfAnyLine());
    mesh->vertices.push_back(v);
  }
  Expect(reader, {"endloop", "endfacet"});
  mesh->triangles.emplace_back(first, first + 1, first + 2);
}

}  // namespace

ObjSurface ParseObjSurface(const std::string& name, std::string_view text) {
  ObjSurface surface;
  WordReader vertices(name, text, true, '#');
  while (vertices.NextLine()) {
    if (vertices.NextWord() != "v") continue;
    Vector3d v;
    for (int k = 0; k < 3; ++k) v[k] = vertices.ParseCoordinate(vertices.NextWord());
    surface.vertices.push_back(v);  // what may follow, a weight or a colour, is of no interest
    if (surface.vertices.size() > kMaxVertices) vertices.Fail(fmt::format("more than {} vertices", kMaxVertices));
  }
  // Faces may name vertices that come after them, so they are read when all vertices are known.
  VertexCount count{static_cast<long long>(surface.vertices.size()), 0};
  WordReader faces(name, text, true, '#');
  while (faces.NextLine()) {
    const std::string_view keyword = faces.NextWord();
    if (keyword == "v") {
      ++count.before;
    } else if (keyword == "f" || keyword == "fo") {  // "fo" is the name of former times
      surface.polygons.push_back(ParseFace(&faces, count));
    } else {
      CheckKeyword(faces, keyword);
    }
  }
  return surface;
}

TriangleMesh ParseTextStl(const std::string& name, std::string_view text) {
  TriangleMesh mesh;
  WordReader reader(name, text, false, 0);
  Expect(&reader, {"solid"});
  bool has_solid = true;
  while (has_solid) {
    // The solid's name, which may be several words, ends with the line.
    while (!reader.NextWord().empty()) {
    }
    while (true) {
      const std::string_view word = reader.NextWordOfAnyLine();
      if (word.empty()) reader.Fail("the file ends without 'endsolid'");
      const std::string keyword = ToLowerCase(word);
      if (keyword == "endsolid") break;
      if (keyword != "facet") {
        reader.Fail(fmt::format("expected 'facet' or 'endsolid', found '{}'", WordReader::Shorten(word)));
      }
      ParseFacet(&reader, &mesh);
    }
    has_solid = reader.NextLine() && ToLowerCase(reader.NextWord()) == "solid";
  }
  return mesh;
}

bool BeginsAsTextStl(std::string_view text) {
  text = SkipByteOrderMark(text);
  const std::size_t begin = text.find_first_not_of(" \t\r\n\v\f");
  return begin != std::string_view::npos && ToLowerCase(text.substr(begin, 5)) == "solid";
}

}  // namespace knap
