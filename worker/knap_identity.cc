#include "worker/knap_identity.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "sim/rollout/known_numbers.h"

namespace knap {

EngineIdentity MakeKnapIdentity(const std::string& program) {
  std::ifstream file(program, std::ios::binary);
  std::ostringstream bytes;
  if (!file || !(bytes << file.rdbuf())) throw std::runtime_error(program + ": cannot be read");
  return {"knap", FormatShort(CalcSha256(bytes.str())), CalcFingerprint(CalcKnownNumbers())};
}

}  // namespace knap
