#include "worker/knap_engine.h"
#include "worker/worker_program.h"

int main(int argc, char** argv) { return knap::RunWorkerProgram(argc, argv, knap::MakeEngine()); }
