#include "coordinator/run/runs_progress.h"

#include "knap/run_status_t.hpp"

namespace knap {

void ShowRunsProgress(ProgressState state, bool done, const std::string& scenario, const std::string& method,
                      const JournaledService& service, ClusterSession* session, StderrProgress* shown) {
  state.phase = ProgressPhase::kStudying;
  state.rollouts = service.answered();
  state.workers_wanted = session->workers_wanted();
  state.workers_alive = session->dispatcher().CountUsableWorkers();
  state.retries = session->dispatcher().counters().reissued;
  if (done) {
    shown->Finish(state);
  } else {
    shown->Update(state);
  }
  RunProgress progress;
  progress.state = run_status_t::kLearning;
  if (done) progress.state = run_status_t::kDone;
  progress.progress = done ? 1.0 : CalcDonePart(state);
  progress.eta_s = CalcTimeLeft(state).value_or(-1.0);
  progress.batch = state.runs_done;
  progress.batch_count = state.runs;
  progress.scenario = scenario;
  progress.method = method;
  session->dispatcher().SetProgress(progress);
}

}  // namespace knap
