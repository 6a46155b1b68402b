// Open on every message type: the first byte of an input chooses the type and whether fingerprint and digest are made
// right, as a holder of the key could; the rest are the message's bytes.
#include <algorithm>
#include <type_traits>

#include "lcmtypes/wire/codec.h"
#include "tests/fuzz/fuzz_target.h"

namespace knap {
namespace {

const RunKey kKey;

template <typename T>
void Try(std::vector<std::uint8_t> bytes, bool forge) {
  if (forge && bytes.size() >= 24) {
    const auto fingerprint = static_cast<std::uint64_t>(T::getHash());
    for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(fingerprint >> (56 - 8 * i));
    const RunKey::Digest digest = kKey.CalcDigest(bytes.data(), bytes.size());
    std::copy(digest.begin(), digest.end(), bytes.end() - static_cast<std::ptrdiff_t>(digest.size()));
  }
  Refusal refusal = Refusal::kNone;
  const auto message = Open<T>(bytes.data(), bytes.size(), kKey, &refusal);
  Require(message.has_value() == (refusal == Refusal::kNone), "a message or a reason, never both");
  Require(forge || !message || kKey.Verify(bytes.data(), bytes.size()), "nothing unsigned is accepted");
  if (!message) return;
  // Texts are made clean, which may shorten them; everything else, and a clean text, is as it was sent.
  const std::vector<std::uint8_t> sealed = Seal(*message, kKey);
  Require(sealed.size() <= bytes.size(), "what is accepted never grows");
  const auto again = Open<T>(sealed.data(), sealed.size(), kKey, nullptr);
  Require(again && Seal(*again, kKey) == sealed, "what was made clean stays as it is");
  if constexpr (std::is_same_v<T, rollout_request_t> || std::is_same_v<T, scenario_t>) {
    Require(sealed == bytes, "what is accepted is what was sent");
  }
}

template <typename T>
void AddSeeds(char type, T message, std::vector<std::string>* seeds) {
  for (const char forge : {'\0', '\10'}) {
    const std::vector<std::uint8_t> bytes = Seal(message, kKey);
    seeds->push_back(static_cast<char>(type | forge) + std::string(bytes.begin(), bytes.end()));
  }
}

}  // namespace
}  // namespace knap

std::vector<std::string> MakeSeeds() {
  using namespace knap;
  std::vector<std::string> seeds;
  rollout_request_t request{};
  request.assignments.resize(2);
  for (assignment_t& assignment : request.assignments) {
    assignment.theta_size = 3;
    assignment.values = {1.0, 2.0, 3.0};
  }
  request.acknowledged.assign(64, 7);
  AddSeeds(0, request, &seeds);
  rollout_result_t result{};
  result.gradient_size = 2;
  result.values = {0.5, -0.5};
  result.worker = "worker";
  result.error = "an error";
  AddSeeds(1, result, &seeds);
  worker_status_t status{};
  status.queue.assign(96, 3);
  status.name = status.engine = status.build = status.host = status.reason = "name";
  AddSeeds(2, status, &seeds);
  run_status_t run{};
  run.theta = {1.0, 2.0};
  run.scenario = run.method = "text";
  AddSeeds(3, run, &seeds);
  scenario_t piece{};
  piece.data.assign(100, 9);
  AddSeeds(4, piece, &seeds);
  control_t control{};
  control.ids.assign(64, 5);
  control.chunks = {1, 2, 3};
  control.worker = "worker";
  AddSeeds(5, control, &seeds);
  return seeds;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace knap;
  if (size == 0) return 0;
  const bool forge = (data[0] & 8) != 0;
  const std::vector<std::uint8_t> bytes(data + 1, data + size);
  switch (data[0] & 7) {
    case 0:
      Try<rollout_request_t>(bytes, forge);
      break;
    case 1:
      Try<rollout_result_t>(bytes, forge);
      break;
    case 2:
      Try<worker_status_t>(bytes, forge);
      break;
    case 3:
      Try<run_status_t>(bytes, forge);
      break;
    case 4:
      Try<scenario_t>(bytes, forge);
      break;
    case 5:
      Try<control_t>(bytes, forge);
      break;
    default:
      break;
  }
  return 0;
}
