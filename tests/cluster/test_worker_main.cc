#include <memory>

#include "tests/worker/closed_form_engine.h"
#include "worker/worker_program.h"

int main(int argc, char** argv) {
  return knap::RunWorkerProgram(argc, argv,
                                {{"closed_form", [] { return std::make_unique<knap::ClosedFormEngine>(); }}});
}
