#include "coordinator/cli/cluster_flags.h"

namespace knap {

void AddClusterFlags(CLI::App* command, ClusterOptions* options, bool own_engines) {
  CLI::Option* workers =
      command->add_option("--workers", options->workers, "workers to start here (default: one a core)");
  workers->check(CLI::Range(1, 1024));
  CLI::Option* external =
      command->add_flag("--external", options->external, "start none: workers are started elsewhere");
  external->excludes(workers);
  CLI::Option* engine =
      command->add_option("--engine", options->engine,
                          own_engines ? "bullet: initial and learned design in both engines (default: knap, the "
                                        "differentiable simulator)"
                                      : "workers' engine (default: knap, the differentiable simulator)");
  // Of knap-worker's engines this one alone has gradients.
  if (!own_engines) engine->needs(external);
  command->add_option("--lcm-url", options->lcm_url,
                      "LCM network (default: LCM_DEFAULT_URL, else a free port; with --external LCM's default)");
  command->add_option("--key", options->key_file,
                      "file with the run's key (default: a new one; with --external a public one)");
  command->add_option("--wait", options->no_worker_s, "seconds to wait for a first or another worker (default: 30)")
      ->check(CLI::Range(0.1, 1e6));
}

}  // namespace knap
