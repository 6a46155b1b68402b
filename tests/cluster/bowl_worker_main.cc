#include <memory>

#include "tests/worker/bowl_engine.h"
#include "worker/worker_program.h"

int main(int argc, char** argv) {
  return knap::RunWorkerProgram(argc, argv, {{"bowl", [] { return std::make_unique<knap::BowlEngine>(); }}});
}
