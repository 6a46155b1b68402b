// How far many runs are that learn at a time on one pool, as those of a study: on stderr and on LCM.
#pragma once

#include <string>

#include "coordinator/progress/progress.h"
#include "coordinator/progress/stderr_progress.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run/cluster_session.h"

namespace knap {

// `state` tells title, time and runs; what answers and workers add to it is asked of service and session. `method` is
// what bystanders hear. `done`: shows the end, and leaves it standing.
void ShowRunsProgress(ProgressState state, bool done, const std::string& scenario, const std::string& method,
                      const JournaledService& service, ClusterSession* session, StderrProgress* shown);

}  // namespace knap
