// Fetches one scenario bundle piece by piece: at most kChunksPerControl pieces are asked for at a time, what does not
// come is asked for again, and the whole is believed only when its hash is the wanted one.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "knap/scenario_t.hpp"
#include "lcmtypes/wire/content_id.h"

namespace knap {

class ScenarioFetch {
 public:
  explicit ScenarioFetch(const ContentId& scenario) : scenario_(scenario) {}

  const ContentId& scenario() const { return scenario_; }

  // Takes a piece; pieces of other scenarios and impossible ones are ignored.
  void Add(const scenario_t& piece);

  // The pieces to ask for now: those asked for before and still missing first. Empty until everything asked for has
  // come or `retry_after_us` has passed since it was asked; also empty when complete.
  std::vector<std::int32_t> ChooseWanted(std::int64_t now_us, std::int64_t retry_after_us);

  // The bundle's bytes once they are complete and their hash is right, else null; a wrong hash starts all over.
  std::shared_ptr<const std::string> TakeBundle();

 private:
  ContentId scenario_;
  std::string bytes_;
  std::vector<bool> have_;  // one flag a piece; empty until the first piece tells how many there are
  std::size_t missing_ = 0;
  std::vector<std::int32_t> asked_;
  std::optional<std::int64_t> asked_at_us_;
};

}  // namespace knap
