#include "worker/scenario_fetch.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/scenario_bundle.h"

namespace knap {

void ScenarioFetch::Add(const scenario_t& piece) {
  if (MakeId(piece.scenario) != scenario_ || piece.total_size <= 0) return;
  const std::size_t chunk_size = kBundleChunkSize;
  const std::size_t total = static_cast<std::size_t>(piece.total_size);
  const std::size_t count = (total + chunk_size - 1) / chunk_size;
  const std::size_t chunk = static_cast<std::size_t>(piece.chunk);
  if (have_.empty()) {
    if (static_cast<std::size_t>(piece.chunk_count) != count) return;
    bytes_.assign(total, '\0');
    have_.assign(count, false);
    missing_ = count;
  }
  if (total != bytes_.size() || chunk >= have_.size()) return;
  const std::size_t begin = chunk * chunk_size;
  if (piece.data.size() != std::min(chunk_size, total - begin) || have_[chunk]) return;
  std::copy(piece.data.begin(), piece.data.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin));
  have_[chunk] = true;
  --missing_;
  asked_.erase(std::remove(asked_.begin(), asked_.end(), piece.chunk), asked_.end());
}

std::vector<std::int32_t> ScenarioFetch::ChooseWanted(std::int64_t now_us, std::int64_t retry_after_us) {
  const bool waiting = asked_at_us_ && now_us - *asked_at_us_ < retry_after_us;
  if (waiting && !asked_.empty()) return {};
  asked_.clear();
  if (have_.empty()) {
    asked_.push_back(0);  // tells how many there are
  } else if (missing_ > 0) {
    for (std::size_t i = 0; i < have_.size() && asked_.size() < static_cast<std::size_t>(kChunksPerControl); ++i) {
      if (!have_[i]) asked_.push_back(static_cast<std::int32_t>(i));
    }
  }
  asked_at_us_ = now_us;
  return asked_;
}

std::shared_ptr<const std::string> ScenarioFetch::TakeBundle() {
  if (have_.empty() || missing_ > 0) return nullptr;
  if (CalcScenarioId(bytes_) != scenario_) {
    *this = ScenarioFetch(ContentId(scenario_));
    return nullptr;
  }
  return std::make_shared<const std::string>(std::move(bytes_));
}

}  // namespace knap
