// Sends pieces of the run's scenario to workers that ask for them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "knap/control_t.hpp"
#include "knap/scenario_t.hpp"
#include "lcmtypes/wire/content_id.h"

namespace knap {

class ScenarioServer {
 public:
  // Throws std::runtime_error when the bundle is too large to travel (see EncodeBundle).
  explicit ScenarioServer(std::string bundle);

  const ContentId& scenario() const { return scenario_; }

  // The pieces that this message (kWantScenario) asks for and that exist. What was sent a moment ago, for another
  // worker that asked, is left out: everyone hears the same channel.
  std::vector<scenario_t> MakePieces(const control_t& want, std::int64_t now_us);

 private:
  std::string bundle_;
  ContentId scenario_;
  std::vector<std::optional<std::int64_t>> sent_us_;  // by piece
};

}  // namespace knap
