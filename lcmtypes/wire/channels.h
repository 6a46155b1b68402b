// Channel names and the limits of the wire. docs/protocol.md is their description.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace knap {

inline constexpr std::int32_t kProtocolVersion = 5;

// A message's encoded bytes; with LCM's, UDP's and IP's headers it fits one Ethernet frame.
inline constexpr std::size_t kMaxMessageSize = 1300;
inline constexpr std::int32_t kValuesPerPart = 96;   // doubles in one request or result
inline constexpr std::int32_t kMaxValues = 1 << 20;  // doubles in all parts of one request or result
inline constexpr std::int32_t kAssignmentsPerRequest = 16;
inline constexpr std::int32_t kAcknowledgementsPerRequest = 8;
inline constexpr std::int32_t kIdsPerControl = 32;
inline constexpr std::int32_t kChunksPerControl = 32;
inline constexpr std::int32_t kMaxQueue = 16;             // requests that one worker holds
inline constexpr std::int32_t kBundleChunkSize = 1024;    // [byte]
inline constexpr std::int32_t kMaxBundleSize = 64 << 20;  // [byte]
inline constexpr std::size_t kMaxNameLength = 40;
inline constexpr std::size_t kMaxBuildLength = 64;
inline constexpr std::size_t kMaxHostLength = 64;
inline constexpr std::size_t kMaxReasonLength = 200;
inline constexpr std::size_t kMaxErrorLength = 600;

inline constexpr std::string_view kResultChannel = "KNAP_RESULT";
inline constexpr std::string_view kWorkerStatusChannel = "KNAP_WORKER_STATUS";
inline constexpr std::string_view kRunStatusChannel = "KNAP_RUN_STATUS";
inline constexpr std::string_view kScenarioChannel = "KNAP_SCENARIO";
inline constexpr std::string_view kControlChannel = "KNAP_CONTROL";  // workers to coordinator

inline constexpr std::string_view kRequestPrefix = "KNAP_REQUEST_";
inline std::string MakeRequestChannel(const std::string& worker) { return std::string(kRequestPrefix) + worker; }
inline std::string MakeControlChannel(const std::string& worker) { return "KNAP_CONTROL_" + worker; }

// A worker's or an engine's name is part of channel names and of hashes: 1 to 40 of A-Z a-z 0-9 _ -.
inline bool IsName(std::string_view name) {
  if (name.empty() || name.size() > kMaxNameLength) return false;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!letter && !(c >= '0' && c <= '9') && c != '_' && c != '-') return false;
  }
  return true;
}

}  // namespace knap
