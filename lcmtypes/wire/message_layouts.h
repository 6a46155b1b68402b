// What the codec must know about each message type beyond the generated code: its counts, its texts and its bounds.
//
// SetCounts writes the length fields from the vectors (a wrong count makes the generated encoder read past the end).
// CleanTexts makes every string field what it may hold: clean text (text.h) of at most its limit.
// Scan walks over the encoded fields, after the 8-byte fingerprint, and refuses lengths beyond the limits of
// channels.h.
#pragma once

#include "knap/control_t.hpp"
#include "knap/rollout_request_t.hpp"
#include "knap/rollout_result_t.hpp"
#include "knap/run_status_t.hpp"
#include "knap/scenario_t.hpp"
#include "knap/worker_status_t.hpp"
#include "lcmtypes/wire/wire_scanner.h"

namespace knap {

void SetCounts(rollout_request_t* message);
void SetCounts(rollout_result_t* message);
void SetCounts(worker_status_t* message);
void SetCounts(run_status_t* message);
void SetCounts(scenario_t* message);
void SetCounts(control_t* message);

void CleanTexts(rollout_request_t* message);
void CleanTexts(rollout_result_t* message);
void CleanTexts(worker_status_t* message);
void CleanTexts(run_status_t* message);
void CleanTexts(scenario_t* message);
void CleanTexts(control_t* message);

// The pointer only selects the type.
void Scan(const rollout_request_t*, WireScanner* scanner);
void Scan(const rollout_result_t*, WireScanner* scanner);
void Scan(const worker_status_t*, WireScanner* scanner);
void Scan(const run_status_t*, WireScanner* scanner);
void Scan(const scenario_t*, WireScanner* scanner);
void Scan(const control_t*, WireScanner* scanner);

}  // namespace knap
