#include "lcmtypes/wire/engine_identity.h"

#include <fmt/format.h>

namespace knap {

std::string DescribeMismatch(const EngineIdentity& theirs, const EngineIdentity& ours) {
  if (theirs.build != ours.build) {
    return fmt::format("its program is build '{}', the run's is '{}'", theirs.build, ours.build);
  }
  if (theirs.fingerprint != ours.fingerprint) {
    return fmt::format(
        "it computes other bits ({}) than the run ({}): its processor or its mathematical library rounds otherwise",
        FormatShort(theirs.fingerprint), FormatShort(ours.fingerprint));
  }
  return "";
}

}  // namespace knap
