#include "worker/knap_identity.h"

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "sim/math/check.h"
#include "sim/rollout/known_numbers.h"
#include "sim/transfer/transfer_numbers.h"

namespace knap {

bool IsOwnEngine(const std::string& name) { return name == kKnapEngine || name == kBulletEngine; }

EngineIdentity MakeOwnIdentity(const std::string& engine, const std::string& program) {
  KNAP_CHECK(IsOwnEngine(engine), "knap-worker has no engine '{}'", engine);
  std::ifstream file(program, std::ios::binary);
  std::ostringstream bytes;
  if (!file || !(bytes << file.rdbuf())) throw std::runtime_error(program + ": cannot be read");
  std::vector<double> numbers = CalcKnownNumbers();
  if (engine == kBulletEngine) {
    const std::vector<double> of_bullet = CalcTransferNumbers();
    numbers.insert(numbers.end(), of_bullet.begin(), of_bullet.end());
  }
  return {engine, FormatShort(CalcSha256(bytes.str())), CalcFingerprint(numbers)};
}

}  // namespace knap
