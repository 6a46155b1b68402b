#include "worker/bullet_engine.h"
#include "worker/knap_engine.h"
#include "worker/knap_identity.h"
#include "worker/worker_program.h"

int main(int argc, char** argv) {
  return knap::RunWorkerProgram(
      argc, argv, {{knap::kKnapEngine, knap::MakeKnapEngine}, {knap::kBulletEngine, knap::MakeBulletEngine}});
}
