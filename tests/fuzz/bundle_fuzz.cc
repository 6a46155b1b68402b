// Scenario bundles, which a worker decodes after their hash was right.
#include <stdexcept>

#include "lcmtypes/wire/scenario_bundle.h"
#include "tests/fuzz/fuzz_target.h"

std::vector<std::string> MakeSeeds() {
  return {knap::EncodeBundle({}), knap::EncodeBundle({{"scenario.yaml", "schema: 2"}, {"meshes/a.stl", "solid"}}),
          knap::EncodeBundle({{"", ""}, {"b", std::string(300, 'x')}})};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  try {
    Require(knap::EncodeBundle(knap::DecodeBundle(bytes)) == bytes, "what is decoded is what was encoded");
  } catch (const std::runtime_error&) {  // refused with a line
  }
  return 0;
}
