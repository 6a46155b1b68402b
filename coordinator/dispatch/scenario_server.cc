#include "coordinator/dispatch/scenario_server.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/scenario_bundle.h"

namespace knap {
namespace {

constexpr std::int64_t kJustNowUs = 10'000;  // well below the time after which a worker asks again
constexpr std::size_t kChunk = kBundleChunkSize;

}  // namespace

ScenarioServer::ScenarioServer(std::string bundle)
    : bundle_(std::move(bundle)),
      scenario_(CalcScenarioId(bundle_)),
      sent_us_((bundle_.size() + kChunk - 1) / kChunk) {}

std::vector<scenario_t> ScenarioServer::MakePieces(const control_t& want, std::int64_t now_us) {
  std::vector<scenario_t> pieces;
  if (MakeId(want.scenario) != scenario_) return pieces;
  for (const std::int32_t chunk : want.chunks) {
    if (chunk < 0 || static_cast<std::size_t>(chunk) >= sent_us_.size()) continue;
    const std::size_t index = static_cast<std::size_t>(chunk);
    if (sent_us_[index] && now_us - *sent_us_[index] < kJustNowUs) continue;
    sent_us_[index] = now_us;
    const std::size_t begin = index * kChunk;
    const std::size_t end = std::min(bundle_.size(), begin + kChunk);
    scenario_t piece{};
    piece.chunk = chunk;
    piece.chunk_count = static_cast<std::int32_t>(sent_us_.size());
    piece.total_size = static_cast<std::int32_t>(bundle_.size());
    piece.data.assign(bundle_.begin() + static_cast<std::ptrdiff_t>(begin),
                      bundle_.begin() + static_cast<std::ptrdiff_t>(end));
    CopyId(scenario_, piece.scenario);
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

}  // namespace knap
