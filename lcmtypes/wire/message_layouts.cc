#include "lcmtypes/wire/message_layouts.h"

#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/run_key.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

constexpr std::size_t kScalar64 = 8;
constexpr std::size_t kScalar32 = 4;
constexpr std::size_t kId = 32;

template <typename Vector>
std::int32_t Count(const Vector& v) {
  return static_cast<std::int32_t>(v.size());
}

void Clean(std::string* text, std::size_t max_length) { *text = CleanText(*text, max_length); }

}  // namespace

void SetCounts(rollout_request_t* message) {
  message->assignment_count = Count(message->assignments);
  for (assignment_t& assignment : message->assignments) assignment.value_count = Count(assignment.values);
  message->acknowledged_size = Count(message->acknowledged);
}

void CleanTexts(rollout_request_t*) {}

void Scan(const rollout_request_t*, WireScanner* scanner) {
  scanner->Skip(5 * kScalar64);
  const std::size_t assignments = scanner->TakeCount(kAssignmentsPerRequest);
  const std::size_t acknowledged = scanner->TakeCount(kAcknowledgementsPerRequest * static_cast<std::int32_t>(kId));
  scanner->Skip(kId);
  for (std::size_t k = 0; k < assignments; ++k) {
    scanner->Skip(2 * kScalar32);
    for (int i = 0; i < 6; ++i) scanner->TakeCount(kMaxValues);  // five sizes and the first index
    const std::size_t values = scanner->TakeCount(kValuesPerPart);
    scanner->Skip(kId + values * kScalar64);
  }
  scanner->Skip(acknowledged + RunKey::kDigestSize);
}

void SetCounts(rollout_result_t* message) { message->value_count = Count(message->values); }

void CleanTexts(rollout_result_t* message) {
  Clean(&message->worker, kMaxNameLength);
  Clean(&message->distrust, kMaxReasonLength);
  Clean(&message->error, kMaxErrorLength);
}

void Scan(const rollout_result_t*, WireScanner* scanner) {
  scanner->Skip(12 * kScalar64 + 9 * kScalar32);
  for (int i = 0; i < 2; ++i) scanner->TakeCount(kMaxValues);  // gradient size and first index
  const std::size_t values = scanner->TakeCount(kValuesPerPart);
  scanner->Skip(kId + values * kScalar64);
  scanner->SkipString(kMaxNameLength);
  scanner->SkipString(kMaxReasonLength);
  scanner->SkipString(kMaxErrorLength);
  scanner->Skip(RunKey::kDigestSize);
}

void SetCounts(worker_status_t* message) { message->queue_size = Count(message->queue); }

void CleanTexts(worker_status_t* message) {
  Clean(&message->name, kMaxNameLength);
  Clean(&message->engine, kMaxNameLength);
  Clean(&message->build, kMaxBuildLength);
  Clean(&message->host, kMaxHostLength);
  Clean(&message->reason, kMaxReasonLength);
}

void Scan(const worker_status_t*, WireScanner* scanner) {
  scanner->Skip(12 * kScalar64 + 5 * kScalar32);
  const std::size_t queue = scanner->TakeCount(kMaxQueue * static_cast<std::int32_t>(kId));
  scanner->Skip(3 * kId + queue);
  scanner->SkipString(kMaxNameLength);
  scanner->SkipString(kMaxNameLength);
  scanner->SkipString(kMaxBuildLength);
  scanner->SkipString(kMaxHostLength);
  scanner->SkipString(kMaxReasonLength);
  scanner->Skip(RunKey::kDigestSize);
}

void SetCounts(run_status_t* message) { message->theta_size = Count(message->theta); }

void CleanTexts(run_status_t* message) {
  Clean(&message->scenario, kMaxHostLength);
  Clean(&message->method, kMaxNameLength);
}

void Scan(const run_status_t*, WireScanner* scanner) {
  scanner->Skip(12 * kScalar64 + 11 * kScalar32);
  const std::size_t theta = scanner->TakeCount(kValuesPerPart);
  scanner->Skip(theta * kScalar64);
  scanner->SkipString(kMaxHostLength);
  scanner->SkipString(kMaxNameLength);
  scanner->Skip(RunKey::kDigestSize);
}

void SetCounts(scenario_t* message) { message->data_size = Count(message->data); }

void CleanTexts(scenario_t*) {}

void Scan(const scenario_t*, WireScanner* scanner) {
  scanner->Skip(4 * kScalar64);
  for (int i = 0; i < 2; ++i) scanner->TakeCount(kMaxBundleSize / kBundleChunkSize);  // chunk, chunk count
  scanner->TakeCount(kMaxBundleSize);
  const std::size_t data = scanner->TakeCount(kBundleChunkSize);
  scanner->Skip(kId + data + RunKey::kDigestSize);
}

void SetCounts(control_t* message) {
  message->ids_size = Count(message->ids);
  message->chunk_count = Count(message->chunks);
}

void CleanTexts(control_t* message) { Clean(&message->worker, kMaxNameLength); }

void Scan(const control_t*, WireScanner* scanner) {
  scanner->Skip(5 * kScalar64 + kScalar32);
  const std::size_t ids = scanner->TakeCount(kIdsPerControl * static_cast<std::int32_t>(kId));
  const std::size_t chunks = scanner->TakeCount(kChunksPerControl);
  scanner->Skip(kId + ids + chunks * kScalar32);
  scanner->SkipString(kMaxNameLength);
  scanner->Skip(RunKey::kDigestSize);
}

}  // namespace knap
