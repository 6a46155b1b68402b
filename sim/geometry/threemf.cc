#include "sim/geometry/threemf.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <utility>

namespace knap {
namespace {

// The checksum of ZIP, PNG and Ethernet: the reflected polynomial 0xEDB88320.
std::uint32_t CalcCrc32(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xEDB88320 : 0);
  }
  return ~crc;
}

// An archive of stored files [APPNOTE 6.3, 4.3]: each behind a header of its own, then the directory and its end.
class StoredZip {
 public:
  void Add(std::string_view name, std::string_view bytes) {
    std::string entry;
    Append(20, 2, &entry);      // version that is needed
    Append(0, 2, &entry);       // no flags
    Append(0, 2, &entry);       // stored
    Append(0, 2, &entry);       // midnight …
    Append(0x0021, 2, &entry);  // … of the first of January 1980, always
    Append(CalcCrc32(bytes), 4, &entry);
    Append(bytes.size(), 4, &entry);
    Append(bytes.size(), 4, &entry);
    Append(name.size(), 2, &entry);
    Append(0, 2, &entry);  // nothing extra
    const std::size_t offset = archive_.size();
    Append(0x04034b50, 4, &archive_);
    archive_.append(entry).append(name).append(bytes);

    Append(0x02014b50, 4, &directory_);
    Append(20, 2, &directory_);  // version that made it
    directory_.append(entry);
    Append(0, 2, &directory_);  // no comment
    Append(0, 2, &directory_);  // first disk
    Append(0, 2, &directory_);  // internal attributes
    Append(0, 4, &directory_);  // external ones
    Append(offset, 4, &directory_);
    directory_.append(name);
    ++count_;
  }

  std::string Finish() && {
    const std::size_t offset = archive_.size();
    archive_ += directory_;
    Append(0x06054b50, 4, &archive_);
    Append(0, 2, &archive_);  // this disk
    Append(0, 2, &archive_);  // that of the directory
    Append(count_, 2, &archive_);
    Append(count_, 2, &archive_);
    Append(directory_.size(), 4, &archive_);
    Append(offset, 4, &archive_);
    Append(0, 2, &archive_);  // no comment
    return std::move(archive_);
  }

 private:
  // The lowest byte first.
  static void Append(std::uint64_t value, int bytes, std::string* out) {
    for (int i = 0; i < bytes; ++i) out->push_back(static_cast<char>(value >> (8 * i) & 0xFF));
  }

  std::string archive_, directory_;
  std::uint64_t count_ = 0;
};

std::string EscapeXml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

constexpr std::string_view kTypes = R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
)";

constexpr std::string_view kRelationships = R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
)";

}  // namespace

std::string Write3mf(const TriangleMesh& mesh, const std::string& name) {
  std::string model = R"(<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
<resources>
)";
  const auto out = std::back_inserter(model);
  fmt::format_to(out, "<object id=\"1\" type=\"model\" name=\"{}\">\n<mesh>\n<vertices>\n", EscapeXml(name));
  for (const Eigen::Vector3d& v : mesh.vertices) {
    const Eigen::Vector3f mm = (1000.0 * v).cast<float>();
    fmt::format_to(out, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n", mm.x(), mm.y(), mm.z());
  }
  model += "</vertices>\n<triangles>\n";
  for (const Eigen::Vector3i& t : mesh.triangles) {
    fmt::format_to(out, "<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>\n", t[0], t[1], t[2]);
  }
  model += "</triangles>\n</mesh>\n</object>\n</resources>\n<build>\n<item objectid=\"1\"/>\n</build>\n</model>\n";
  StoredZip zip;
  zip.Add("[Content_Types].xml", kTypes);
  zip.Add("_rels/.rels", kRelationships);
  zip.Add("3D/3dmodel.model", model);
  return std::move(zip).Finish();
}

}  // namespace knap
