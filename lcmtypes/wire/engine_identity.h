// What a worker and a run must have in common before the worker gets work: engines with equal identities answer every
// request with the same bits.
#pragma once

#include <string>

#include "lcmtypes/wire/content_id.h"

namespace knap {

struct EngineIdentity {
  std::string name;         // IsName; part of every request's id
  std::string build;        // of the program that computes, <= kMaxBuildLength; empty when there is but one
  ContentId fingerprint{};  // of numbers that this machine computed with it (CalcFingerprint); zeros when it needs none
};

// One sentence that says why a worker with the identity `theirs` may not work for a run with the identity `ours`; empty
// when it may. Names are not looked at.
std::string DescribeMismatch(const EngineIdentity& theirs, const EngineIdentity& ours);

}  // namespace knap
